#include "isolux/io/chosen_volume.h"

#include "isolux/base/error.h"

namespace isolux {

std::uint64_t chosen_volume(const ReadRequest& request, ReadResult& result) {
  if (result.volume_count == 1) return 0;
  const int chosen = request.grid.volume.value_or(0);
  const std::string count = std::to_string(result.volume_count);
  if (chosen < 0 || chosen >= result.volume_count) {
    throw UsageError(
        "--volume",
        "is " + std::to_string(chosen) + ", but " + request.name + " has " + count + " volumes",
        "count from 0 to " + std::to_string(result.volume_count - 1));
  }
  result.notes.push_back("volume " + std::to_string(chosen) + " of " + count +
                         ", counted from 0 (--volume)");
  return static_cast<std::uint64_t>(chosen);
}

}  // namespace isolux
