#include "isolux/io/stored_voxels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"

namespace isolux {
namespace {

// Calls `use` with a value of the C++ type that a StoredType stands for.
template <typename Use>
decltype(auto) with_type(StoredType type, Use&& use) {
  switch (type) {
    case StoredType::kI8:
      return use(std::int8_t{});
    case StoredType::kU8:
      return use(std::uint8_t{});
    case StoredType::kI16:
      return use(std::int16_t{});
    case StoredType::kU16:
      return use(std::uint16_t{});
    case StoredType::kI32:
      return use(std::int32_t{});
    case StoredType::kU32:
      return use(std::uint32_t{});
    case StoredType::kI64:
      return use(std::int64_t{});
    case StoredType::kU64:
      return use(std::uint64_t{});
    case StoredType::kF32:
      return use(float{});
    case StoredType::kF64:
      break;
  }
  return use(double{});
}

template <typename Stored>
inline constexpr bool kIsVoxelType =
    std::is_same_v<Stored, std::uint8_t> || std::is_same_v<Stored, std::int16_t> ||
    std::is_same_v<Stored, std::uint16_t> || std::is_same_v<Stored, float>;

// What is read, and how.
struct Task {
  const std::string& name;
  StoredType type;
  std::size_t count;
  bool swapped;
  Rescale rescale;
  const std::function<ReadNext()>& from_the_first;
};

template <typename Voxel>
std::vector<Voxel> room_for(const Task& task) {
  check_memory(static_cast<double>(task.count) * sizeof(Voxel), task.name);
  return std::vector<Voxel>(task.count);
}

// Whether a voxel of this type holds the value as it is.
template <typename Voxel>
bool holds(double value) {
  if constexpr (std::is_floating_point_v<Voxel>) {
    return static_cast<double>(static_cast<Voxel>(value)) == value || std::isnan(value);
  } else {
    return value >= std::numeric_limits<Voxel>::lowest() &&
           value <= std::numeric_limits<Voxel>::max() && value == std::floor(value);
  }
}

// Reads and converts piece by piece. A whole-number type ends at the first value that it does not
// hold, and nothing is returned; floats round, which is told.
template <typename Voxel, typename Stored>
std::optional<VoxelArray> converted(const Task& task, std::vector<std::string>& notes) {
  constexpr std::size_t kPiece = 1 << 16;
  std::vector<Voxel> voxels = room_for<Voxel>(task);
  std::vector<Stored> piece(std::min(kPiece, task.count));
  const ReadNext next = task.from_the_first();
  bool is_exact = true;
  for (std::size_t begin = 0; begin < task.count; begin += kPiece) {
    const std::size_t count = std::min(kPiece, task.count - begin);
    next(reinterpret_cast<char*>(piece.data()), count * sizeof(Stored));
    if (task.swapped) swap_bytes(task.type, piece.data(), count);
    for (std::size_t n = 0; n < count; ++n) {
      const double value =
          task.rescale.slope * static_cast<double>(piece[n]) + task.rescale.intercept;
      if (!holds<Voxel>(value)) {
        if constexpr (!std::is_floating_point_v<Voxel>) return std::nullopt;
        is_exact = false;
      }
      voxels[begin + n] = static_cast<Voxel>(value);
    }
  }
  if (!is_exact) notes.push_back("its values are rounded to 32-bit floats");
  return voxels;
}

template <typename Stored>
VoxelArray narrowest(const Task& task, std::vector<std::string>& notes) {
  // A float file keeps its type, so that a range seen by chance does not decide it.
  if constexpr (!std::is_floating_point_v<Stored>) {
    if constexpr (sizeof(Stored) == 1) {
      if (const auto voxels = converted<std::uint8_t, Stored>(task, notes)) return *voxels;
    }
    if (const auto voxels = converted<std::int16_t, Stored>(task, notes)) return *voxels;
    if (const auto voxels = converted<std::uint16_t, Stored>(task, notes)) return *voxels;
  }
  return *converted<float, Stored>(task, notes);
}

// The voxels as they lie in their file, where they can be mapped.
template <typename Voxel>
std::optional<VoxelArray> mapped(const std::vector<Stretch>& stretches) {
  constexpr std::uint64_t kLarge = 64 << 20;  // docs/decisions/0010-mapped-voxels.md
  if (stretches.size() != 1 || stretches[0].bytes < kLarge) return std::nullopt;
  const StoredBytes& file = stretches[0].file;
  const std::uint64_t offset = file.offset + stretches[0].skip;
  if (file.deflated || file.bzip2 || offset % sizeof(Voxel) != 0) return std::nullopt;
  const auto bytes = std::make_shared<const MappedFile>(file.path);
  if (offset > bytes->size() || stretches[0].bytes > bytes->size() - offset) return std::nullopt;
  return Voxels<Voxel>(bytes, offset, stretches[0].bytes / sizeof(Voxel));
}

// One swap for each width, which the compiler turns into the processor's own.
template <std::size_t kWidth>
void swap_numbers(char* bytes, std::size_t count) {
  for (std::size_t n = 0; n < count; ++n, bytes += kWidth) std::reverse(bytes, bytes + kWidth);
}

}  // namespace

std::size_t bytes_of(StoredType type) {
  return with_type(type, [](auto value) { return sizeof value; });
}

VoxelArray voxels_read(const std::string& name, StoredType type, std::size_t count, bool swapped,
                       const Rescale& rescale, const std::function<ReadNext()>& from_the_first,
                       std::vector<std::string>& notes) {
  const Task task{name, type, count, swapped, rescale, from_the_first};
  return with_type(type, [&]<typename Stored>(Stored) -> VoxelArray {
    if constexpr (kIsVoxelType<Stored>) {
      if (rescale == Rescale{}) {
        std::vector<Stored> voxels = room_for<Stored>(task);
        from_the_first()(reinterpret_cast<char*>(voxels.data()), count * sizeof(Stored));
        if (swapped) swap_bytes(type, voxels.data(), count);
        return voxels;
      }
    }
    return narrowest<Stored>(task, notes);
  });
}

VoxelArray voxels_of_stretches(const ReadRequest& request, StoredType type, bool swapped,
                               const Rescale& rescale, const std::vector<Stretch>& stretches,
                               std::vector<std::string>& notes) {
  if (!swapped && rescale == Rescale{}) {
    const auto as_they_lie =
        with_type(type, [&]<typename Stored>(Stored) -> std::optional<VoxelArray> {
          if constexpr (kIsVoxelType<Stored>) return mapped<Stored>(stretches);
          return std::nullopt;
        });
    if (as_they_lie) return *as_they_lie;
  }
  std::uint64_t bytes = 0;
  for (const Stretch& stretch : stretches) bytes += stretch.bytes;
  check_large_stretches(stretches);
  const auto from_the_first = [&]() -> ReadNext {
    const auto reader = std::make_shared<StretchReader>(stretches, request.listener);
    return [reader](char* to, std::size_t count) { reader->read(to, count); };
  };
  return voxels_read(request.name, type, bytes / bytes_of(type), swapped, rescale, from_the_first,
                     notes);
}

void swap_bytes(StoredType type, void* stored, std::size_t count) {
  char* bytes = static_cast<char*>(stored);
  switch (bytes_of(type)) {
    case 2:
      return swap_numbers<2>(bytes, count);
    case 4:
      return swap_numbers<4>(bytes, count);
    case 8:
      return swap_numbers<8>(bytes, count);
    default:
      return;
  }
}

void check_promise(const std::string& name, double promised, double available,
                   const std::string& encoding) {
  // Deflate's best is 1032 : 1; bzip2's, on one byte repeated, some 45,000 : 1.
  const double best = encoding == "raw" ? 1 : encoding == "bzip2" || encoding == "bz2" ? 5e4 : 1100;
  if (!(promised <= available * best)) {
    throw WorkError(name,
                    "its header promises " + to_text(promised) + " bytes, but only " +
                        to_text(std::max(0.0, available)) + " bytes of " + encoding +
                        " data are there",
                    "is the file complete?");
  }
  // Scans shrink to a third, label volumes to a hundredth. What unpacks to more than that and is
  // large is more likely meant to do harm.
  constexpr double kLarge = 1e9, kUsualRatio = 200;
  if (promised > kLarge && promised > kUsualRatio * available && !memory_limit_is_set()) {
    throw WorkError(name, "unpacks to " + bytes_text(promised) + ", over 200 times its size",
                    "if that is right, allow it by --max-memory");
  }
}

}  // namespace isolux
