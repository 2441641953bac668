#include "isolux/volume/phantom.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isolux {
namespace {

double value_at(const Volume& volume, int i, int j, int k) {
  return visit_voxels(volume, [&](const auto& view) { return view.value(i, j, k); });
}

TEST(Phantom, the_sphere_is_one_less_a_32nd_of_the_distance) {
  const Volume volume = sphere_phantom();
  EXPECT_EQ(volume.dims, (std::array{65, 65, 65}));
  EXPECT_EQ(voxel_type_name(volume), "f32");
  EXPECT_EQ(volume.world_from_index.point({32, 32, 32}), (Vec3{0, 0, 0}));
  EXPECT_EQ(spacing_mm(volume), (Vec3{1, 1, 1}));
  EXPECT_EQ(value_at(volume, 32, 32, 32), 1);
  EXPECT_EQ(value_at(volume, 48, 32, 32), 0.5);
}

TEST(Phantom, marschner_lobb_has_the_papers_values) {
  const Volume volume = marschner_lobb_phantom();
  EXPECT_EQ(volume.dims, (std::array{41, 41, 41}));
  EXPECT_NEAR(spacing_mm(volume).x, 0.05, 1e-15);
  // At the middle: rho(0) = cos(2 pi 6) = 1, so (1 - 0 + 0.25 * 2) / 2.5.
  EXPECT_NEAR(value_at(volume, 20, 20, 20), 0.6, 1e-6);
  // At (1, 0, 1): rho(1) = cos(0) = 1 and sin(pi / 2) = 1, so 0.5 / 2.5.
  EXPECT_NEAR(value_at(volume, 40, 20, 40), 0.2, 1e-6);
}

TEST(Phantom, another_size_keeps_the_distance_between_the_outermost_voxels) {
  for (const int size : {2, 17, 100}) {
    EXPECT_NEAR(sphere_phantom(size).world_from_index.point({size - 1.0, 0, 0}).x, 32, 1e-12);
    EXPECT_NEAR(marschner_lobb_phantom(size).world_from_index.point({size - 1.0, 0, 0}).x, 1,
                1e-12);
  }
  EXPECT_NEAR(head_phantom(32).world_from_index.point({31, 31, 31}).z, 127.5, 1e-12);
}

TEST(Phantom, the_head_is_in_hounsfield_units_with_air_brain_and_bone) {
  const Volume head = head_phantom(64);
  EXPECT_EQ(head.units, "HU");
  EXPECT_EQ(voxel_type_name(head), "i16");
  EXPECT_EQ(value_at(head, 0, 0, 63), -1000);
  EXPECT_NEAR(value_at(head, 32, 34, 40), 35, 15);  // the brain
  double greatest = 0;
  for (int i = 0; i < 64; ++i) greatest = std::fmax(greatest, value_at(head, i, 34, 48));
  EXPECT_GT(greatest, 700);  // the skull's side
}

TEST(Phantom, the_head_differs_from_its_mirror_image_only_on_the_left_ears_side) {
  const Volume head = head_phantom(64);
  int left_denser = 0, right_denser = 0;
  for (int k = 0; k < 64; ++k) {
    for (int j = 0; j < 64; ++j) {
      for (int i = 32; i < 64; ++i) {  // +x is the patient's left
        const double more = value_at(head, i, j, k) - value_at(head, 63 - i, j, k);
        if (i >= 48 && more > 500) ++left_denser;
        if (more < -500) ++right_denser;
      }
    }
  }
  EXPECT_GT(left_denser, 10);
  EXPECT_EQ(right_denser, 0);
}

}  // namespace
}  // namespace isolux
