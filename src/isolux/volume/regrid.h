#pragma once

#include <array>

#include "isolux/volume/volume.h"

namespace isolux {

/// A block of voxels, `first` and `last` included.
struct VoxelBlock {
  std::array<int, 3> first;
  std::array<int, 3> last;
};

/// The voxels of a block, where they were in the world. 0 <= first <= last < dims along each axis.
Volume cropped(const Volume& volume, const VoxelBlock& block);

/// The trilinear interpolant sampled at another distance between voxel centres, from voxel (0, 0,
/// 0) on and as far as the volume goes, with the same axes. Whole-number types are rounded to
/// nearest; a sample whose cell has a NaN corner that counts is NaN. Each of `spacing_mm` is above
/// 0.
Volume resampled(const Volume& volume, Vec3 spacing_mm);

/// How many voxels `resampled` would make along each axis, unrounded by memory or type limits.
std::array<double, 3> resampled_dims(const Volume& volume, Vec3 spacing_mm);

}  // namespace isolux
