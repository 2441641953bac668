// One fuzz target for each reader: ISOLUX_FUZZ_FORMAT, given by CMake, says which. Whatever the
// bytes, reading them ends in a volume or in an isolux::Error; a crash, a hang, a leak of another
// exception or more memory than the limit is a finding.

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/io/reader.h"
#include "isolux/scene/description.h"

namespace isolux::fuzz {
namespace {

const std::string kFormat = ISOLUX_FUZZ_FORMAT;

void read_scene(const std::string& bytes) {
  const nlohmann::json document = nlohmann::json::parse(bytes, nullptr, false);
  if (!document.is_discarded()) describe(document, "scene");
}

void read_volume(const std::string& bytes) {
  static const std::string path = (std::filesystem::temp_directory_path() /
                                   ("isolux-fuzz-" + kFormat + "-" + std::to_string(::getpid())))
                                      .string();
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
  try {
    const ReadResult result = read_input({path, {}});
    if (voxel_count(*result.volume) == 0) std::abort();
  } catch (...) {
    std::filesystem::remove(path);
    throw;
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace isolux::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr double kMemory = 64e6;
  isolux::set_memory_limit(kMemory);
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  try {
    isolux::fuzz::kFormat == "scene" ? isolux::fuzz::read_scene(bytes)
                                     : isolux::fuzz::read_volume(bytes);
  } catch (const isolux::Error&) {
  }
  return 0;
}
