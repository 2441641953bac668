#include "isolux/volume/regrid.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isolux {
namespace {

// Value 100 i + 10 j + k on a sheared, mirrored grid.
Volume digits() {
  Volume volume;
  volume.dims = {4, 3, 5};
  volume.world_from_index = {{{{2, 0, 0}, {1, -3, 0}, {0, 0, 0.5}}}, {10, 20, 30}};
  std::vector<float> voxels;
  for (int k = 0; k < 5; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 4; ++i) voxels.push_back(static_cast<float>(100 * i + 10 * j + k));
    }
  }
  volume.voxels = voxels;
  return volume;
}

double value(const Volume& volume, int i, int j, int k) {
  return visit_voxels(volume, [&](const auto& view) { return view.value(i, j, k); });
}

TEST(Regrid, a_cropped_volume_has_its_voxels_where_they_were) {
  const Volume volume = digits();
  const Volume part = cropped(volume, {{1, 0, 2}, {3, 1, 4}});
  EXPECT_EQ(part.dims, (std::array{3, 2, 3}));
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 3; ++i) EXPECT_EQ(value(part, i, j, k), value(volume, i + 1, j, k + 2));
    }
  }
  EXPECT_EQ(part.world_from_index.point({0, 0, 0}), volume.world_from_index.point({1, 0, 2}));
  EXPECT_EQ(part.world_from_index.linear, volume.world_from_index.linear);
}

TEST(Regrid, resampling_a_linear_field_keeps_it_linear_and_in_place) {
  const Volume volume = digits();
  const Vec3 old = spacing_mm(volume);
  const Volume fine = resampled(volume, 0.25 * old);
  EXPECT_EQ(fine.dims, (std::array{13, 9, 17}));
  EXPECT_NEAR(value(fine, 5, 6, 7), 100 * 1.25 + 10 * 1.5 + 1.75, 1e-4);
  const Vec3 far = fine.world_from_index.point({12, 8, 16});
  EXPECT_NEAR(length(far - volume.world_from_index.point({3, 2, 4})), 0, 1e-12);
}

TEST(Regrid, resampling_to_the_same_spacing_changes_nothing) {
  const Volume volume = digits();
  const Volume same = resampled(volume, spacing_mm(volume));
  EXPECT_EQ(same.dims, volume.dims);
  EXPECT_EQ(same.voxels, volume.voxels);
}

TEST(Regrid, whole_numbers_stay_whole_and_are_rounded_to_nearest) {
  Volume volume;
  volume.dims = {2, 1, 1};
  volume.voxels = std::vector<std::int16_t>{-3, 0};
  EXPECT_EQ(resampled(volume, {0.5, 1, 1}).voxels,
            VoxelArray(std::vector<std::int16_t>{-3, -1, 0}));
}

}  // namespace
}  // namespace isolux
