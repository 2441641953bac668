#include "isolux/intersect/skip_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "isolux/base/parallel.h"
#include "isolux/volume/cell.h"

namespace isolux {
namespace {

using Block = SkipGrid::Block;

// Mostly one value, with a few others strewn in.
template <typename T>
Volume strewn_volume(const std::array<int, 3>& dims, unsigned seed, std::vector<T> rare) {
  std::mt19937 random(seed);
  std::vector<T> voxels(static_cast<std::size_t>(dims[0] * dims[1] * dims[2]));
  for (T& voxel : voxels) voxel = random() % 400 == 0 ? rare[random() % rare.size()] : T{0};
  Volume volume;
  volume.dims = dims;
  volume.voxels = std::move(voxels);
  return volume;
}

bool can_hold(const Volume& volume, const CellIndex& cell, double iso) {
  return visit_voxels(volume, [&](const auto& view) {
    bool above = false, below = false;
    for (const double corner : cell_corners(view, cell)) {
      if (!std::isfinite(corner)) return false;
      above |= corner >= iso;
      below |= corner <= iso;
    }
    return above && below;
  });
}

void expect_right(const Volume& volume, double iso) {
  const SkipGrid grid(volume, BrickGrid(volume), iso);
  std::vector<Block> full;
  for (int k = 0; k < volume.dims[2] - 1; ++k) {
    for (int j = 0; j < volume.dims[1] - 1; ++j) {
      for (int i = 0; i < volume.dims[0] - 1; ++i) {
        const std::size_t at = grid.index({i / 4, j / 4, k / 4});
        const bool bit = grid.cells()[at] >> (i % 4 + 4 * (j % 4) + 16 * (k % 4)) & 1;
        EXPECT_EQ(bit, can_hold(volume, {i, j, k}, iso)) << i << " " << j << " " << k;
        if (bit) full.push_back({i / 4, j / 4, k / 4});
      }
    }
  }
  for (int level = 0; level < SkipGrid::kLevels; ++level) {
    std::set<Block> expected;
    for (const auto& [x, y, z] : full) expected.insert({x >> level, y >> level, z >> level});
    const std::vector<Block>& cubes = grid.cubes(level);
    EXPECT_EQ(cubes.size(), expected.size());
    EXPECT_EQ(std::set<Block>(cubes.begin(), cubes.end()), expected);
  }
  for (int z = -1; z <= grid.dims()[2]; ++z) {
    for (int y = -1; y <= grid.dims()[1]; ++y) {
      for (int x = -1; x <= grid.dims()[0]; ++x) {
        for (int octant = 0; octant < 8; ++octant) {
          const auto along = [&](int way, int from, int axis) {
            return octant >> axis & 1 ? from - way : way - from;
          };
          int free = SkipGrid::kGreatestLeap;
          for (const auto& [a, b, c] : full) {
            const auto [least, most] =
                std::minmax({along(a, x, 0), along(b, y, 1), along(c, z, 2)});
            if (least >= 0) free = std::min(free, most);
          }
          const std::uint32_t leaps = grid.leaps()[grid.index({x, y, z})];
          EXPECT_EQ(leaps >> (4 * octant) & 15, static_cast<unsigned>(free))
              << octant << ": " << x << " " << y << " " << z;
        }
      }
    }
  }
}

TEST(SkipGrid, bits_and_leaps_are_those_of_the_definition_for_every_voxel_type) {
  expect_right(strewn_volume<std::int16_t>({37, 22, 41}, 1, {-300, 300}), 0.5);
  expect_right(strewn_volume<std::uint8_t>({30, 30, 18}, 2, {1, 200}), 100);
  expect_right(strewn_volume<std::uint16_t>({9, 90, 10}, 3, {65535}), 65535);
  expect_right(strewn_volume<float>({33, 17, 25}, 4, {1e-3f, -1.5f}), 0.001);
  expect_right(strewn_volume<float>({2, 2, 2}, 5, {1}), 0);
}

TEST(SkipGrid, cells_with_corners_that_are_not_finite_hold_nothing) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  expect_right(strewn_volume<float>({21, 26, 19}, 6, {kNaN, 1, kInfinity, -kInfinity}), 0.25);
}

TEST(SkipGrid, is_the_same_for_any_number_of_threads) {
  const Volume volume = strewn_volume<std::int16_t>({70, 65, 66}, 7, {5});
  const BrickGrid bricks(volume);
  const auto with = [&](int threads) {
    std::unique_ptr<SkipGrid> grid;
    with_threads(threads, [&] { grid = std::make_unique<SkipGrid>(volume, bricks, 1); });
    return grid;
  };
  const auto one = with(1), many = with(5);
  for (int level = 0; level < SkipGrid::kLevels; ++level) {
    EXPECT_EQ(one->cubes(level), many->cubes(level));
  }
  EXPECT_TRUE(std::equal(one->leaps(), one->leaps() + one->size(), many->leaps()));
  EXPECT_TRUE(std::equal(one->cells(), one->cells() + one->size(), many->cells()));
}

}  // namespace
}  // namespace isolux
