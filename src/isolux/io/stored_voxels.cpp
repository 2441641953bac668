#include "isolux/io/stored_voxels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
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

// The values in a stored type, one at a time and without need of alignment.
template <typename Stored>
class StoredValues {
 public:
  StoredValues(const void* bytes, const Rescale& rescale)
      : bytes_(static_cast<const char*>(bytes)), rescale_(rescale) {}
  double operator[](std::size_t n) const {
    Stored value;
    std::memcpy(&value, bytes_ + n * sizeof(Stored), sizeof(Stored));
    return rescale_.slope * static_cast<double>(value) + rescale_.intercept;
  }

 private:
  const char* bytes_;
  Rescale rescale_;
};

template <typename Stored>
inline constexpr bool kIsVoxelType =
    std::is_same_v<Stored, std::uint8_t> || std::is_same_v<Stored, std::int16_t> ||
    std::is_same_v<Stored, std::uint16_t> || std::is_same_v<Stored, float>;

template <typename Voxel, typename Values>
VoxelArray copied(const Values& values, std::size_t count) {
  std::vector<Voxel> voxels(count);
  for (std::size_t n = 0; n < count; ++n) voxels[n] = static_cast<Voxel>(values[n]);
  return voxels;
}

template <typename Voxel>
bool holds(double low, double high) {
  return low >= std::numeric_limits<Voxel>::lowest() && high <= std::numeric_limits<Voxel>::max();
}

template <typename Stored>
VoxelArray rescaled(const void* stored, std::size_t count, const Rescale& rescale,
                    std::vector<std::string>& notes) {
  const StoredValues<Stored> values(stored, rescale);
  double low = 0, high = 0;
  bool all_whole = true, all_float = true;
  for (std::size_t n = 0; n < count; ++n) {
    const double value = values[n];
    low = n == 0 ? value : std::min(low, value);
    high = n == 0 ? value : std::max(high, value);
    all_whole = all_whole && value == std::floor(value);
    all_float =
        all_float && (static_cast<double>(static_cast<float>(value)) == value || std::isnan(value));
  }
  // A float file keeps its type, so that a range seen by chance does not decide it.
  if (all_whole && !std::is_floating_point_v<Stored>) {
    if (holds<std::uint8_t>(low, high) && sizeof(Stored) == 1) {
      return copied<std::uint8_t>(values, count);
    }
    if (holds<std::int16_t>(low, high)) return copied<std::int16_t>(values, count);
    if (holds<std::uint16_t>(low, high)) return copied<std::uint16_t>(values, count);
  }
  if (!all_float) notes.push_back("its values are rounded to 32-bit floats");
  return copied<float>(values, count);
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

VoxelArray voxels_from(StoredType type, const void* stored, std::size_t count,
                       const Rescale& rescale, std::vector<std::string>& notes) {
  return with_type(type, [&]<typename Stored>(Stored) -> VoxelArray {
    if constexpr (kIsVoxelType<Stored>) {
      if (rescale == Rescale{}) {
        std::vector<Stored> voxels(count);
        if (count > 0) std::memcpy(voxels.data(), stored, count * sizeof(Stored));
        return voxels;
      }
    }
    return rescaled<Stored>(stored, count, rescale, notes);
  });
}

VoxelArray voxels_filled(StoredType type, std::size_t count, bool swapped, const Rescale& rescale,
                         std::vector<std::string>& notes,
                         const std::function<void(char* bytes)>& fill) {
  const auto fill_in_order = [&](char* bytes) {
    fill(bytes);
    if (swapped) swap_bytes(type, bytes, count);
  };
  return with_type(type, [&]<typename Stored>(Stored) -> VoxelArray {
    if constexpr (kIsVoxelType<Stored>) {
      if (rescale == Rescale{}) {
        std::vector<Stored> voxels(count);
        fill_in_order(reinterpret_cast<char*>(voxels.data()));
        return voxels;
      }
    }
    std::vector<char> stored(count * sizeof(Stored));
    fill_in_order(stored.data());
    return rescaled<Stored>(stored.data(), count, rescale, notes);
  });
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
  check_memory(promised, name);
}

}  // namespace isolux
