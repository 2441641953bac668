#pragma once

#include <array>
#include <vector>

#include "isolux/volume/volume.h"

namespace isolux {

/// What a brick's cells can hold: the least and greatest of their corner values (NaN left out;
/// low > high where there is no number at all).
struct BrickRange {
  float low;
  float high;
};

/// The ranges of blocks of kCells^3 cells, independent of any iso value: where `iso` is outside a
/// brick's range, no cell of it holds a surface. Exact: every voxel type fits a float.
class BrickGrid {
 public:
  static constexpr int kCells = 8;

  /// One pass over the voxels, on all threads. `volume` must have cells.
  explicit BrickGrid(const Volume& volume);

  /// Memory of the bricks of a volume with these dims, before they are built.
  static double bytes(const std::array<int, 3>& volume_dims);

  const std::array<int, 3>& dims() const { return dims_; }  ///< bricks along i, j, k
  const std::vector<BrickRange>& ranges() const { return ranges_; }
  const BrickRange& at(const std::array<int, 3>& brick) const {
    return ranges_[index(brick[0], brick[1], brick[2])];
  }

 private:
  template <typename T>
  void fill_row(const VolumeView<T>& v, int b, int c);

  std::size_t index(int a, int b, int c) const {
    return static_cast<std::size_t>(a) +
           static_cast<std::size_t>(dims_[0]) *
               (static_cast<std::size_t>(b) +
                static_cast<std::size_t>(dims_[1]) * static_cast<std::size_t>(c));
  }

  std::array<int, 3> dims_;
  std::vector<BrickRange> ranges_;
};

}  // namespace isolux
