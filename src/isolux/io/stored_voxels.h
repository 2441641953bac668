#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

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

/// Copies `count` stored numbers (in this machine's byte order, not necessarily aligned) into the
/// narrowest of Volume's voxel types that holds every rescaled value exactly; 32-bit floats where
/// none of the whole-number types does. Says in `notes` where floats round.
VoxelArray voxels_from(StoredType type, const void* stored, std::size_t count,
                       const Rescale& rescale, std::vector<std::string>& notes);

/// As voxels_from, for `count` numbers that `fill` writes to where it is told: straight into their
/// place in the result where they need no conversion. `swapped`: they come in the other byte order.
VoxelArray voxels_filled(StoredType type, std::size_t count, bool swapped, const Rescale& rescale,
                         std::vector<std::string>& notes,
                         const std::function<void(char* bytes)>& fill);

/// Swaps the bytes of each of `count` numbers.
void swap_bytes(StoredType type, void* stored, std::size_t count);

/// @throws WorkError  where `promised` bytes of voxels cannot come from `available` bytes of a file
/// in the given encoding ("raw", "gzip", ...), unpack to over 1 GB and 200 times their size though
/// no memory limit was set, or do not fit this machine's memory. Called before anything is
/// allocated; `name` is the file.
void check_promise(const std::string& name, double promised, double available,
                   const std::string& encoding);

}  // namespace isolux
