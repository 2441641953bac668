#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "isolux/io/reader.h"
#include "isolux/io/stored_bytes.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// The number types that files store voxels in.
enum class StoredType { kI8, kU8, kI16, kU16, kI32, kU32, kI64, kU64, kF32, kF64 };

/// Calls `use` with a value of the C++ type that a StoredType stands for.
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

std::size_t bytes_of(StoredType type);

/// value = slope * stored + intercept.
struct Rescale {
  double slope = 1;
  double intercept = 0;
  bool operator==(const Rescale&) const = default;
};

/// Several numbers a voxel, one behind the other, of which one is made (channels.h).
struct Channels {
  int count = 1;
  bool is_colour = false;  ///< they are red, green, blue, and perhaps alpha, in 8 bits: their luma
  int chosen = 0;          ///< else this one
};

/// Writes the next `bytes` of stored numbers to where it is told.
using ReadNext = std::function<void(char* to, std::size_t bytes)>;

/// Turns `count` stored numbers into the narrowest of Volume's voxel types that holds every
/// rescaled value exactly; 32-bit floats where none of the whole-number types does. Says in `notes`
/// where floats round. Numbers that need no conversion are read straight into their place; of
/// others nothing larger than a buffer is kept beside the voxels. For that they may be read several
/// times: each call of `from_the_first` begins again.
/// @param swapped  they come in the other byte order than this machine's.
/// @throws WorkError  about `name`, where the voxels exceed the memory limit; and as ReadNext does.
VoxelArray voxels_read(const std::string& name, StoredType type, std::size_t count, bool swapped,
                       const Rescale& rescale, const std::function<ReadNext()>& from_the_first,
                       std::vector<std::string>& notes);

/// "i16", "f64", ...
std::string name_of(StoredType type);

/// The most bytes that a voxel of voxels_read takes.
double bytes_per_voxel_most(StoredType type, const Rescale& rescale);

/// Sets how the voxels of an opened input are to be read: from stretches of files, as voxels_read
/// does. Where there is nothing to convert, one stretch holds all and it is large
/// (docs/decisions/0010-mapped-voxels.md), they are to be mapped from the file instead.
void plan_voxels(OpenedInput& opened, const ReadRequest& request, StoredType type, bool swapped,
                 const Rescale& rescale, std::vector<Stretch> stretches,
                 const Channels& channels = {});

/// Swaps the bytes of each of `count` numbers.
void swap_bytes(StoredType type, void* stored, std::size_t count);

/// @throws WorkError  where `promised` bytes of voxels cannot come from `available` bytes of a file
/// in the given encoding ("raw", "gzip", ...), or unpack to over 1 GB and 200 times their size
/// though no memory limit was set. Called before anything is allocated; `name` is the file.
void check_promise(const std::string& name, double promised, double available,
                   const std::string& encoding);

}  // namespace isolux
