#include <cstdlib>
#include <filesystem>
#include <map>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/io/format.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

struct Phantom {
  Volume (*make)(int size);
  int size;
};

const std::map<std::string, Phantom>& phantoms() {
  static const std::map<std::string, Phantom> all = {
      {"head", {head_phantom, 256}},
      {"sphere", {sphere_phantom, 65}},
      {"marschner-lobb", {marschner_lobb_phantom, 41}},
  };
  return all;
}

constexpr int kLargestSize = 4096;

}  // namespace

OpenedInput open_phantom(const ReadRequest& request) {
  const std::string rest = request.name.substr(std::string("phantom:").size());
  const std::size_t comma = rest.find(',');
  const auto found = phantoms().find(rest.substr(0, comma));
  if (found == phantoms().end()) {
    throw UsageError(request.name, "there is no such phantom",
                     "there are phantom:head, phantom:sphere and phantom:marschner-lobb");
  }
  int size = found->second.size;
  if (comma != std::string::npos) {
    const std::string setting = rest.substr(comma + 1);
    const auto given =
        setting.starts_with("size=") ? parse_whole_number(setting.substr(5)) : std::nullopt;
    if (!given || *given < 2 || *given > kLargestSize) {
      throw UsageError(request.name, "'" + setting + "' is no size",
                       "write size=N with N from 2 to " + std::to_string(kLargestSize));
    }
    size = static_cast<int>(*given);
  }
  const Phantom& phantom = found->second;
  OpenedInput opened;
  opened.result.name = request.name;
  opened.result.format = "built-in";
  // The smallest one, of 2 voxels a side, spans the same cube and says the same of itself.
  opened.volume = phantom.make(2);
  opened.stored_type = voxel_type_name(opened.volume);
  opened.bytes_per_voxel_most = static_cast<double>(voxel_bytes(opened.volume)) / 8;
  opened.volume.voxels = {};
  opened.volume.dims = {size, size, size};
  Mat3& linear = opened.volume.world_from_index.linear;
  for (Vec3& column : linear.column) column = column / (size - 1);
  if (request.grid.spacing_mm) linear = diagonal(*request.grid.spacing_mm);
  opened.read_voxels = [make = phantom.make, size, name = request.name,
                        bytes = opened.voxel_memory()](std::vector<std::string>&) {
    check_memory(bytes, name);
    return make(size).voxels;
  };
  return opened;
}

std::string find_example_head() {
  namespace fs = std::filesystem;
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value ? value : "");
  };
  std::vector<fs::path> places = {"/usr/share/doc/invesalius-examples/examples/Cranium.inv3"};
  if (!variable("XDG_CACHE_HOME").empty()) {
    places.push_back(variable("XDG_CACHE_HOME") / "isolux/Cranium.inv3");
  } else if (!variable("HOME").empty()) {
    places.push_back(variable("HOME") / ".cache/isolux/Cranium.inv3");
  }
  for (const fs::path& path : places) {
    std::error_code error;
    if (fs::is_regular_file(path, error)) return path.string();
  }
  return {};
}

}  // namespace isolux
