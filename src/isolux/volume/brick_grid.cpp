#include "isolux/volume/brick_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

template <typename T>
BrickRange range_of_brick(const VolumeView<T>& v, int a, int b, int c) {
  constexpr int n = BrickGrid::kCells;
  BrickRange range{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
  // A brick of n cells has n + 1 voxels along an axis: it shares its border with its neighbour.
  for (int k = c * n; k <= std::min((c + 1) * n, v.dims[2] - 1); ++k) {
    for (int j = b * n; j <= std::min((b + 1) * n, v.dims[1] - 1); ++j) {
      for (int i = a * n; i <= std::min((a + 1) * n, v.dims[0] - 1); ++i) {
        const float value = static_cast<float>(v.voxels[v.offset(i, j, k)]);
        if (std::isnan(value)) continue;
        range.low = std::min(range.low, value);
        range.high = std::max(range.high, value);
      }
    }
  }
  return range;
}

int bricks_along(int voxels) { return (voxels - 1 + BrickGrid::kCells - 1) / BrickGrid::kCells; }

}  // namespace

double BrickGrid::bytes(const std::array<int, 3>& volume_dims) {
  double bricks = 1;
  for (const int count : volume_dims) bricks *= bricks_along(count);
  return bricks * sizeof(BrickRange);
}

BrickGrid::BrickGrid(const Volume& volume) {
  for (std::size_t axis = 0; axis < 3; ++axis) dims_[axis] = bricks_along(volume.dims[axis]);
  ranges_.resize(index(0, 0, dims_[2]));
  visit_voxels(volume, [&](const auto& view) {
    parallel_for(static_cast<std::size_t>(dims_[2]), 1, [&](std::size_t begin, std::size_t end) {
      for (int c = static_cast<int>(begin); c < static_cast<int>(end); ++c) {
        for (int b = 0; b < dims_[1]; ++b) {
          for (int a = 0; a < dims_[0]; ++a)
            ranges_[index(a, b, c)] = range_of_brick(view, a, b, c);
        }
      }
    });
  });
}

}  // namespace isolux
