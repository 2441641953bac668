// One fuzz target for each reader: ISOLUX_FUZZ_FORMAT, given by CMake, says which. Whatever the
// bytes, reading them ends in a volume or in an isolux::Error; a crash, a hang, a leak of another
// exception or more memory than the limit is a finding.

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
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

// A folder of its own for the input, since reading a DICOM file looks at its neighbours.
class InputFolder {
 public:
  InputFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "isolux-fuzz-XXXXXX").string();
    if (!::mkdtemp(name.data())) std::abort();
    folder_ = name;
  }
  ~InputFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  InputFolder(const InputFolder&) = delete;
  InputFolder& operator=(const InputFolder&) = delete;

  std::string file() const { return (folder_ / ("input." + kFormat)).string(); }

 private:
  std::filesystem::path folder_;
};

// A headerless file has its grid on the command line: here in its first four bytes, three sizes and
// a type.
GridDescription take_grid(std::string& bytes) {
  constexpr const char* kTypes[] = {"u8", "i16", "i16be", "u16", "u16be", "f32", "f32be"};
  GridDescription grid;
  if (kFormat != "raw" || bytes.size() < 4) return grid;
  const auto number = [&](std::size_t n) { return static_cast<unsigned char>(bytes[n]); };
  grid.dims = {number(0) + 1, number(1) + 1, number(2) + 1};
  grid.type = kTypes[number(3) % std::size(kTypes)];
  bytes.erase(0, 4);
  return grid;
}

void read_volume(std::string bytes) {
  static const InputFolder folder;
  const std::string path = folder.file();
  const GridDescription grid = take_grid(bytes);
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
  const ReadResult result = read_input({path, grid});
  if (voxel_count(*result.volume) == 0) std::abort();
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
