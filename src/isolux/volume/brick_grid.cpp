#include "isolux/volume/brick_grid.h"

#include <algorithm>

#include "isolux/base/parallel.h"
#include "isolux/volume/row_ranges.h"

namespace isolux {
namespace {

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
        for (int b = 0; b < dims_[1]; ++b) fill_row(view, b, c);
      }
    });
  });
}

// The bricks (0, b, c), (1, b, c), ...: first over j and k for each i, then along i. A brick of n
// cells has n + 1 voxels along an axis: it shares its border with its neighbour.
template <typename T>
void BrickGrid::fill_row(const VolumeView<T>& v, int b, int c) {
  const int count = v.dims[0];
  const RowBlock block{std::min(kCells + 1, v.dims[1] - b * kCells),
                       std::min(kCells + 1, v.dims[2] - c * kCells), v.dims[0],
                       static_cast<std::ptrdiff_t>(v.offset(0, 0, 1))};
  std::vector<T> low(static_cast<std::size_t>(count)), high(low.size());
  row_ranges(v.voxels + v.offset(0, b * kCells, c * kCells), count, block, low.data(), high.data());
  for (int a = 0; a < dims_[0]; ++a) {
    const int first = a * kCells, last = std::min(first + kCells, count - 1);
    const T least = *std::min_element(low.begin() + first, low.begin() + last + 1);
    const T greatest = *std::max_element(high.begin() + first, high.begin() + last + 1);
    ranges_[index(a, b, c)] = {static_cast<float>(least), static_cast<float>(greatest)};
  }
}

}  // namespace isolux
