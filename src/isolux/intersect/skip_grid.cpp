#include "isolux/intersect/skip_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

constexpr int kBrick = BrickGrid::kCells;
static_assert(kBrick == 2 * SkipGrid::kBlockCells);

// The least T at or above a value and the greatest at or below it: comparing with these is
// comparing with the value. The value lies in the range of the voxels, and so of T.
template <typename T>
struct Threshold {
  T at_least;
  T at_most;

  explicit Threshold(double iso) {
    if constexpr (std::is_integral_v<T>) {
      at_least = static_cast<T>(std::ceil(iso));
      at_most = static_cast<T>(std::floor(iso));
    } else {
      const T near = static_cast<T>(iso);
      constexpr T kInfinity = std::numeric_limits<T>::infinity();
      at_least = near >= iso ? near : std::nextafter(near, kInfinity);
      at_most = near <= iso ? near : std::nextafter(near, -kInfinity);
    }
  }
};

// One bit for each of the 9 voxels along i that a row of 8 cells touches.
struct RowBits {
  unsigned above = 0;  ///< at or above the iso value
  unsigned below = 0;  ///< at or below it
  unsigned wild = 0;   ///< not finite
};

template <typename T>
RowBits row_bits(const T* voxels, int count, Threshold<T> threshold) {
  RowBits bits;
  for (int i = 0; i < count; ++i) {
    const T value = voxels[i];
    bits.above |= static_cast<unsigned>(value >= threshold.at_least) << i;
    bits.below |= static_cast<unsigned>(value <= threshold.at_most) << i;
    if constexpr (std::is_floating_point_v<T>) {
      bits.wild |= static_cast<unsigned>(!std::isfinite(value)) << i;
    }
  }
  return bits;
}

RowBits operator|(const RowBits& a, const RowBits& b) {
  return {a.above | b.above, a.below | b.below, a.wild | b.wild};
}

// The words of a brick's 2 x 2 x 2 blocks.
using BrickWords = std::array<std::uint64_t, 8>;

template <typename T>
BrickWords surface_cells(const VolumeView<T>& v, const std::array<int, 3>& brick,
                         Threshold<T> threshold) {
  std::array<int, 3> first, voxels;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first[axis] = brick[axis] * kBrick;
    voxels[axis] = std::min(kBrick + 1, v.dims[axis] - first[axis]);
  }
  std::array<std::array<RowBits, kBrick + 1>, kBrick + 1> rows;
  for (int z = 0; z < voxels[2]; ++z) {
    for (int y = 0; y < voxels[1]; ++y) {
      rows[z][y] =
          row_bits(v.voxels + v.offset(first[0], first[1] + y, first[2] + z), voxels[0], threshold);
    }
  }
  BrickWords words{};
  const unsigned cells_in_row = (1u << (voxels[0] - 1)) - 1;
  for (int z = 0; z + 1 < voxels[2]; ++z) {
    for (int y = 0; y + 1 < voxels[1]; ++y) {
      const RowBits edges = rows[z][y] | rows[z][y + 1] | rows[z + 1][y] | rows[z + 1][y + 1];
      const unsigned above = edges.above | edges.above >> 1;
      const unsigned below = edges.below | edges.below >> 1;
      const unsigned wild = edges.wild | edges.wild >> 1;
      const std::uint64_t cells = above & below & ~wild & cells_in_row;
      const std::size_t block = static_cast<std::size_t>((y >> 2) * 2 + (z >> 2) * 4);
      const int shift = (y & 3) * 4 + (z & 3) * 16;
      words[block] |= (cells & 15) << shift;
      words[block + 1] |= (cells >> 4) << shift;
    }
  }
  return words;
}

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
            const BrickWords words = surface_cells(view, brick, Threshold<T>(iso));
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
  for (const auto& slab : found) blocks_.insert(blocks_.end(), slab.begin(), slab.end());
  measure_distances();
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
  return static_cast<double>(leaps_.size()) + 8 * static_cast<double>(size()) +
         static_cast<double>(blocks_.size() * sizeof(Block));
}

}  // namespace isolux
