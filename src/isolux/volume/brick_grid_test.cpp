#include "isolux/volume/brick_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

Volume ramp(std::array<int, 3> dims) {
  Volume volume;
  volume.dims = dims;
  std::vector<float> voxels;
  for (int n = 0; n < dims[0] * dims[1] * dims[2]; ++n) voxels.push_back(static_cast<float>(n));
  volume.voxels = voxels;
  return volume;
}

TEST(BrickGrid, a_brick_covers_its_cells_corners_and_no_more) {
  const Volume volume = ramp({18, 2, 2});  // 17 cells: bricks of 8, 8 and 1
  const BrickGrid bricks(volume);
  EXPECT_EQ(bricks.dims(), (std::array{3, 1, 1}));
  EXPECT_EQ(bricks.at({0, 0, 0}).low, 0);
  EXPECT_EQ(bricks.at({0, 0, 0}).high, 8 + 18 * 3);  // voxel (8, 1, 1)
  EXPECT_EQ(bricks.at({1, 0, 0}).low, 8);            // voxel (8, 0, 0), shared
  EXPECT_EQ(bricks.at({2, 0, 0}).low, 16);
  EXPECT_EQ(bricks.at({2, 0, 0}).high, 17 + 18 * 3);
}

TEST(BrickGrid, nan_is_left_out) {
  Volume volume = ramp({2, 2, 2});
  volume.voxels = std::vector<float>{NAN, 1, 2, 3, 4, 5, 6, 7};
  const BrickGrid some(volume);
  EXPECT_EQ(some.at({0, 0, 0}).low, 1);
  volume.voxels = std::vector<float>(8, NAN);
  const BrickGrid none(volume);
  EXPECT_GT(none.at({0, 0, 0}).low, none.at({0, 0, 0}).high);
}

TEST(BrickGrid, the_bricks_of_a_volume_hold_all_its_values) {
  const Volume volume = sphere_phantom(30);
  const BrickGrid bricks(volume);
  visit_voxels(volume, [&](const auto& view) {
    for (int k = 0; k < 29; ++k) {
      for (int j = 0; j < 29; ++j) {
        for (int i = 0; i < 29; ++i) {
          const BrickRange& range = bricks.at({i / 8, j / 8, k / 8});
          for (int corner = 0; corner < 8; ++corner) {
            const double value =
                view.value(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2));
            ASSERT_LE(range.low, value);
            ASSERT_GE(range.high, value);
          }
        }
      }
    }
  });
}

}  // namespace
}  // namespace isolux
