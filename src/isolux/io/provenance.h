#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "isolux/image/metadata.h"
#include "isolux/io/reader.h"

// What a picture carries so that it can be made again: version, scene, command and checksums; no
// time, output path, thread count or instruction set.

namespace isolux {

/// Checksums of one input's files, in the order in which they were read.
struct InputChecksums {
  std::string input;                ///< as the scene names it
  std::vector<std::string> sha256;  ///< empty for built-in volumes, which the version fixes
};

InputChecksums checksums_of(const ReadResult& input);

/// The texts for a PNG or EXR: "Software", "isolux.scene", "isolux.command", "isolux.inputs".
Metadata provenance(const std::string& version, const nlohmann::json& document,
                    const std::vector<InputChecksums>& inputs);

struct Provenance {
  std::string version;
  std::string scene;  ///< the scene document as JSON text
  std::vector<InputChecksums> inputs;
  bool is_exr = false;
};

/// Reads the provenance back from a PNG or EXR that isolux wrote.
/// @throws WorkError  where the file is unreadable or carries none.
Provenance read_provenance(const std::string& picture_path);

}  // namespace isolux
