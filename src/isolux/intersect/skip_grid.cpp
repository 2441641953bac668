#include "isolux/intersect/skip_grid.h"

#include <algorithm>
#include <new>

#include "isolux/base/parallel.h"
#include "isolux/intersect/surface_cells.h"

namespace isolux {
namespace {

static_assert(BrickGrid::kCells == 2 * SkipGrid::kBlockCells);

// out[x] = min over r of max(|r|, in[x + r * step]), for a row of `count` elements whose
// neighbours along the axis lie `step` apart, from `at` of `length`.
void nearest_along(const std::uint8_t* in, std::uint8_t* out, std::size_t count,
                   std::ptrdiff_t step, int at, int length) {
  std::copy_n(in, count, out);
  for (int r = 1; r < SkipGrid::kGreatestLeap; ++r) {
    for (const int side : {-r, r}) {
      if (at + side < 0 || at + side >= length) continue;
      const std::uint8_t* row = in + side * step;
      const auto least = static_cast<std::uint8_t>(r);
      for (std::size_t x = 0; x < count; ++x) out[x] = std::min(out[x], std::max(row[x], least));
    }
  }
}

}  // namespace

SkipGrid::SkipGrid(const Volume& volume, const BrickGrid& bricks, double iso) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    dims_[axis] = (volume.dims[axis] - 1 + kBlockCells - 1) / kBlockCells;
  }
  stride_y_ = static_cast<std::size_t>(dims_[0]) + 2;
  stride_z_ = stride_y_ * (static_cast<std::size_t>(dims_[1]) + 2);
  const std::size_t count = stride_z_ * (static_cast<std::size_t>(dims_[2]) + 2);
  leaps_.assign(count + kPadding, kGreatestLeap);
  cells_.reset(static_cast<std::uint64_t*>(std::calloc(count, sizeof(std::uint64_t))));
  if (!cells_) throw std::bad_alloc();

  std::vector<std::vector<Block>> found(static_cast<std::size_t>(bricks.dims()[2]));
  visit_voxels(volume, [&]<typename T>(const VolumeView<T>& view) {
    parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t slab = begin; slab < end; ++slab) {
        std::array<int, 3> brick{0, 0, static_cast<int>(slab)};
        for (brick[1] = 0; brick[1] < bricks.dims()[1]; ++brick[1]) {
          for (brick[0] = 0; brick[0] < bricks.dims()[0]; ++brick[0]) {
            const BrickRange& range = bricks.at(brick);
            if (!(range.low <= iso && range.high >= iso)) continue;
            const BrickCells words = surface_cells(view, brick, Threshold<T>(iso));
            for (int n = 0; n < 8; ++n) {
              if (words[static_cast<std::size_t>(n)] == 0) continue;
              const Block block{2 * brick[0] + (n & 1), 2 * brick[1] + (n >> 1 & 1),
                                2 * brick[2] + (n >> 2)};
              cells_[index(block)] = words[static_cast<std::size_t>(n)];
              leaps_[index(block)] = 0;
              found[slab].push_back(block);
            }
          }
        }
      }
    });
  });
  for (const auto& slab : found) cubes_[0].insert(cubes_[0].end(), slab.begin(), slab.end());
  gather_cubes();
  measure_distances();
}

// Each level from the one before: a cube of it holds up to eight of those.
void SkipGrid::gather_cubes() {
  Block dims = dims_;
  for (std::size_t level = 1; level < kLevels; ++level) {
    for (std::int32_t& count : dims) count = (count + 1) / 2;
    std::vector<std::uint8_t> is_there(static_cast<std::size_t>(dims[0]) *
                                       static_cast<std::size_t>(dims[1]) *
                                       static_cast<std::size_t>(dims[2]));
    for (const Block& part : cubes_[level - 1]) {
      const Block cube{part[0] / 2, part[1] / 2, part[2] / 2};
      std::uint8_t& known = is_there[static_cast<std::size_t>(
          cube[0] + std::int64_t{dims[0]} * (cube[1] + std::int64_t{dims[1]} * cube[2]))];
      if (!known) cubes_[level].push_back(cube);
      known = 1;
    }
  }
}

// The Chebyshev distance is separable: along i first, then the nearest along j of what was found,
// then along k.
void SkipGrid::measure_distances() {
  const auto rows = static_cast<std::size_t>(dims_[1]) + 2;
  const auto slabs = static_cast<std::size_t>(dims_[2]) + 2;
  std::vector<std::uint8_t> in_slabs(leaps_.size());
  parallel_for(slabs, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t z = begin; z < end; ++z) {
      std::uint8_t* slab = leaps_.data() + z * stride_z_;
      for (std::size_t y = 0; y < rows; ++y) {
        std::uint8_t* row = slab + y * stride_y_;
        for (std::size_t x = 1; x < stride_y_; ++x) {
          row[x] = std::min(row[x], static_cast<std::uint8_t>(row[x - 1] + 1));
        }
        for (std::size_t x = stride_y_ - 1; x-- > 0;) {
          row[x] = std::min(row[x], static_cast<std::uint8_t>(row[x + 1] + 1));
        }
      }
      for (std::size_t y = 0; y < rows; ++y) {
        nearest_along(slab + y * stride_y_, in_slabs.data() + z * stride_z_ + y * stride_y_,
                      stride_y_, static_cast<std::ptrdiff_t>(stride_y_), static_cast<int>(y),
                      static_cast<int>(rows));
      }
    }
  });
  parallel_for(rows, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t z = 0; z < slabs; ++z) {
      const std::size_t first = z * stride_z_ + begin * stride_y_;
      nearest_along(in_slabs.data() + first, leaps_.data() + first, (end - begin) * stride_y_,
                    static_cast<std::ptrdiff_t>(stride_z_), static_cast<int>(z),
                    static_cast<int>(slabs));
    }
  });
}

double SkipGrid::bytes() const {
  double bytes = static_cast<double>(leaps_.size()) + 8 * static_cast<double>(size());
  for (const auto& cubes : cubes_) bytes += static_cast<double>(cubes.size() * sizeof(Block));
  return bytes;
}

}  // namespace isolux
