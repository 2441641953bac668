#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "isolux/io/reader.h"
#include "isolux/io/stored_bytes.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// The number types that files store voxels in.
enum class StoredType { kI8, kU8, kI16, kU16, kI32, kU32, kI64, kU64, kF32, kF64 };

std::size_t bytes_of(StoredType type);

/// value = slope * stored + intercept.
struct Rescale {
  double slope = 1;
  double intercept = 0;
  bool operator==(const Rescale&) const = default;
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

/// As voxels_read, from bytes in files. Where there is nothing to convert, one stretch holds all
/// and it is large (docs/decisions/0010-mapped-voxels.md), they are mapped from the file instead.
VoxelArray voxels_of_stretches(const ReadRequest& request, StoredType type, bool swapped,
                               const Rescale& rescale, const std::vector<Stretch>& stretches,
                               std::vector<std::string>& notes);

/// Swaps the bytes of each of `count` numbers.
void swap_bytes(StoredType type, void* stored, std::size_t count);

/// @throws WorkError  where `promised` bytes of voxels cannot come from `available` bytes of a file
/// in the given encoding ("raw", "gzip", ...), or unpack to over 1 GB and 200 times their size
/// though no memory limit was set. Called before anything is allocated; `name` is the file.
void check_promise(const std::string& name, double promised, double available,
                   const std::string& encoding);

}  // namespace isolux
