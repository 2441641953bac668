#pragma once

#include <array>
#include <cstdint>

#include "isolux/volume/volume.h"

namespace isolux {

/// Which of a brick's 8^3 cells can hold a surface: a word for each of its 2 x 2 x 2 blocks of 4^3
/// cells, block (x, y, z) at x + 2 y + 4 z, with a bit for each cell, (x, y, z) at x + 4 y + 16 z.
using BrickCells = std::array<std::uint64_t, 8>;

/// The least value of a voxel type at or above an iso value and the greatest at or below it:
/// comparing with these is comparing with the value, which must lie in the range of T.
template <typename T>
struct Threshold {
  T at_least;
  T at_most;

  explicit Threshold(double iso);
};

/// The cells of a brick (counted in bricks) with corners on both sides of the threshold, or at it,
/// and all of them finite.
template <typename T>
BrickCells surface_cells(const VolumeView<T>& view, const std::array<int, 3>& brick,
                         const Threshold<T>& threshold);

}  // namespace isolux
