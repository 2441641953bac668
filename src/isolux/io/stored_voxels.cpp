#include "isolux/io/stored_voxels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>

#include "isolux/base/error.h"
#include "isolux/base/fence.h"
#include "isolux/base/mapped_file.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/io/channels.h"

namespace isolux {
namespace {

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
  std::vector<Voxel> voxels(task.count);
  keep_from_fences(voxels.data(), task.count * sizeof(Voxel));
  return voxels;
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

// Whether there is nothing to convert.
bool is_as_voxels_are(StoredType type, const Rescale& rescale) {
  return rescale == Rescale{} &&
         with_type(type, []<typename Stored>(Stored) { return kIsVoxelType<Stored>; });
}

bool can_be_mapped(StoredType type, const std::vector<Stretch>& stretches) {
  constexpr std::uint64_t kLarge = 64 << 20;  // docs/decisions/0010-mapped-voxels.md
  if (stretches.size() != 1 || stretches[0].bytes < kLarge) return false;
  const StoredBytes& file = stretches[0].file;
  return !file.deflated && !file.bzip2 && (file.offset + stretches[0].skip) % bytes_of(type) == 0;
}

VoxelArray mapped(StoredType type, const Stretch& stretch) {
  const auto file = std::make_shared<const MappedFile>(stretch.file.path);
  const std::uint64_t offset = stretch.file.offset + stretch.skip;
  if (offset > file->size() || stretch.bytes > file->size() - offset) {
    throw WorkError(stretch.file.path, "was cut short since its header was read",
                    "leave a file alone until isolux is done with it");
  }
  return with_type(type, [&]<typename Stored>(Stored) -> VoxelArray {
    if constexpr (kIsVoxelType<Stored>) {
      return Voxels<Stored>(file, offset, stretch.bytes / sizeof(Stored));
    }
    return {};  // never mapped
  });
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

std::string name_of(StoredType type) {
  constexpr const char* kNames[] = {"i8",  "u8",  "i16", "u16", "i32",
                                    "u32", "i64", "u64", "f32", "f64"};
  return kNames[static_cast<std::size_t>(type)];
}

double bytes_per_voxel_most(StoredType type, const Rescale& rescale) {
  if (is_as_voxels_are(type, rescale)) return static_cast<double>(bytes_of(type));
  const bool is_small = type == StoredType::kI8 && rescale == Rescale{};  // fits 16 bits
  return is_small ? sizeof(std::int16_t) : sizeof(float);
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

void plan_voxels(OpenedInput& opened, const ReadRequest& request, StoredType type, bool swapped,
                 const Rescale& rescale, std::vector<Stretch> stretches, const Channels& channels) {
  opened.stored_type = name_of(type);
  opened.bytes_per_voxel_most = bytes_per_voxel_most(type, rescale);
  if (!swapped && channels.count == 1 && is_as_voxels_are(type, rescale) &&
      can_be_mapped(type, stretches)) {
    opened.is_mapped = true;
    opened.read_voxels = [type, stretch = stretches[0]](std::vector<std::string>&) {
      return mapped(type, stretch);
    };
    return;
  }
  opened.read_voxels = [=](std::vector<std::string>& notes) {
    check_large_stretches(stretches);
    std::uint64_t bytes = 0;
    for (const Stretch& stretch : stretches) bytes += stretch.bytes;
    const auto from_the_first = [&]() -> ReadNext {
      const auto reader = std::make_shared<StretchReader>(stretches, request.listener);
      return one_a_voxel([reader](char* to, std::size_t count) { reader->read(to, count); }, type,
                         channels);
    };
    const std::uint64_t voxel = bytes_of(type) * static_cast<std::uint64_t>(channels.count);
    return voxels_read(request.name, type, bytes / voxel, swapped, rescale, from_the_first, notes);
  };
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
