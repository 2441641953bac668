#include "isolux/io/provenance.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "isolux/base/error.h"
#include "isolux/image/exr.h"
#include "isolux/image/png.h"
#include "isolux/io/checksum.h"
#include "isolux/scene/document.h"

namespace isolux {

using nlohmann::json;

InputChecksums checksums_of(const ReadResult& input) {
  InputChecksums checksums{input.name, {}};
  for (const std::string& file : input.files) checksums.sha256.push_back(sha256_of_file(file));
  return checksums;
}

Metadata provenance(const std::string& version, const json& document,
                    const std::vector<InputChecksums>& inputs) {
  json list = json::array();
  for (const InputChecksums& one : inputs) {
    list.push_back({{"input", one.input}, {"sha256", one.sha256}});
  }
  return {{"Software", "isolux " + version},
          {"isolux.scene", document.dump()},
          {"isolux.command", command_of(document)},
          {"isolux.inputs", list.dump()}};
}

Provenance read_provenance(const std::string& picture_path) {
  std::ifstream file(picture_path, std::ios::binary);
  if (!file) {
    throw WorkError(picture_path, "there is no such picture, or it cannot be read",
                    "check the name");
  }
  std::ostringstream stream;
  stream << file.rdbuf();
  const std::string bytes = stream.str();
  const bool is_exr = bytes.starts_with("\x76\x2f\x31\x01");
  if (!is_exr && !bytes.starts_with("\x89PNG")) {
    throw WorkError(picture_path, "is neither PNG nor EXR", "give a picture that isolux wrote");
  }
  Metadata metadata =
      is_exr ? decode_exr(bytes, picture_path).metadata : decode_png(bytes, picture_path).metadata;
  const std::string software = metadata["Software"];
  if (!software.starts_with("isolux ") || metadata["isolux.scene"].empty()) {
    throw WorkError(picture_path, "does not tell how it was made",
                    "only pictures that isolux wrote can be made again");
  }
  Provenance found{software.substr(7), metadata["isolux.scene"], {}, is_exr};
  try {
    for (const json& one : json::parse(metadata["isolux.inputs"])) {
      found.inputs.push_back({one.at("input"), one.at("sha256").get<std::vector<std::string>>()});
    }
  } catch (const json::exception&) {
    throw WorkError(picture_path, "its record of the inputs is damaged", "was the file edited?");
  }
  return found;
}

}  // namespace isolux
