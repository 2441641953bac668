#include "isolux/io/dicom_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "isolux/base/error.h"

namespace isolux {
namespace {

constexpr double kPi = 3.14159265358979323846;

SlicePlace axial(double z, Vec3 shift = {}) {
  return {.columns = 4,
          .rows = 3,
          .position = Vec3{-10, -20, z} + shift,
          .axes = std::array<Vec3, 2>{Vec3{1, 0, 0}, Vec3{0, 1, 0}},
          .spacing_mm = std::array<double, 2>{0.5, 0.75},
          .distance_mm = 9};
}

std::vector<SlicePlace> axials(const std::vector<double>& heights) {
  std::vector<SlicePlace> slices;
  for (const double z : heights) slices.push_back(axial(z));
  return slices;
}

std::vector<std::size_t> firsts(const SliceStack& stack) {
  std::vector<std::size_t> numbers;
  for (const auto& place : stack.places) numbers.push_back(place.front());
  return numbers;
}

bool says(const SliceStack& stack, const std::string& words) {
  return std::ranges::any_of(
      stack.notes, [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

void expect_near(Vec3 a, Vec3 b) {
  EXPECT_LT(length(a - b), 1e-9) << a.x << " " << a.y << " " << a.z;
}

TEST(DicomGeometry, slices_are_sorted_by_where_they_lie_and_placed) {
  const SliceStack stack = stack_slices("a", axials({6, 2, 4, 8}));
  EXPECT_EQ(firsts(stack), (std::vector<std::size_t>{1, 2, 0, 3}));
  EXPECT_FALSE(stack.is_resampled);
  EXPECT_TRUE(stack.notes.empty());
  expect_near(stack.world_from_index.offset, {-10, -20, 2});
  expect_near(stack.world_from_index.linear.column[0], {0.5, 0, 0});
  expect_near(stack.world_from_index.linear.column[1], {0, 0.75, 0});
  expect_near(stack.world_from_index.linear.column[2], {0, 0, 2});
}

TEST(DicomGeometry, a_mirrored_row_turns_the_normal_and_so_the_order) {
  // Rows to the right, columns to posterior: i x j points to inferior. The grid stays right-handed.
  std::vector<SlicePlace> slices = axials({0, 1, 2});
  for (SlicePlace& slice : slices) slice.axes = {{Vec3{-1, 0, 0}, Vec3{0, 1, 0}}};
  const SliceStack stack = stack_slices("a", slices);
  EXPECT_EQ(firsts(stack), (std::vector<std::size_t>{2, 1, 0}));
  expect_near(stack.world_from_index.offset, {-10, -20, 2});
  expect_near(stack.world_from_index.linear.column[2], {0, 0, -1});
  EXPECT_GT(determinant(stack.world_from_index.linear), 0);
}

TEST(DicomGeometry, a_gantry_tilt_is_a_shear_and_its_angle_is_told) {
  // Each slice 2 mm up is shifted by 2 tan(18.5 deg) to posterior.
  std::vector<SlicePlace> slices;
  const double shift = 2 * std::tan(18.5 * kPi / 180);
  for (int k = 0; k < 5; ++k) slices.push_back(axial(2 * k, {0, shift * k, 0}));
  const SliceStack stack = stack_slices("a", slices);
  EXPECT_TRUE(says(stack, "18.5° gantry tilt: kept as shear"));
  expect_near(stack.world_from_index.linear.column[2], {0, shift, 2});
  for (int k = 0; k < 5; ++k) {
    expect_near(stack.world_from_index.point({0, 0, static_cast<double>(k)}),
                *slices[static_cast<std::size_t>(k)].position);
  }
}

TEST(DicomGeometry, missing_slices_are_filled_and_named) {
  const SliceStack stack = stack_slices("a", axials({0, 2, 4, 10, 12, 14}));
  EXPECT_TRUE(stack.is_resampled);
  EXPECT_TRUE(says(stack, "6 mm from 4 mm to 10 mm")) << stack.notes[0];
  ASSERT_EQ(stack.layers.size(), 8u);
  EXPECT_EQ(stack.layers[2], (Layer{2, 2, 0}));
  EXPECT_EQ(stack.layers[3], (Layer{2, 3, 1.0 / 3}));
  EXPECT_EQ(stack.layers[5], (Layer{3, 3, 0}));
  EXPECT_EQ(stack.layers[7], (Layer{5, 5, 0}));
  expect_near(stack.world_from_index.linear.column[2], {0, 0, 2});
}

TEST(DicomGeometry, a_scan_of_two_slice_distances_takes_the_finer) {
  const SliceStack stack = stack_slices("a", axials({0, 2.5, 5, 7.5, 12.5, 17.5, 22.5, 27.5}));
  EXPECT_EQ(stack.layers.size(), 12u);  // 27.5 / 2.5 + 1
  expect_near(stack.world_from_index.linear.column[2], {0, 0, 2.5});
}

TEST(DicomGeometry, unequal_distances_are_resampled) {
  // The usual step is 2; 10.8 mm in 5 steps of 2.16.
  const SliceStack stack = stack_slices("a", axials({0, 2, 4, 5.4, 8.8, 10.8}));
  EXPECT_TRUE(says(stack, "unequally"));
  ASSERT_EQ(stack.layers.size(), 6u);
  EXPECT_EQ(stack.layers[1].lower, 1u);
  EXPECT_NEAR(stack.layers[1].share_of_upper, 0.08, 1e-9);  // (2.16 - 2) / 2
  EXPECT_EQ(stack.layers[5], (Layer{5, 5, 0}));
}

TEST(DicomGeometry, few_digits_in_the_positions_are_no_gaps) {
  // 0.7 mm steps, rounded to 0.01 mm: within 2 % of a step.
  const SliceStack stack = stack_slices("a", axials({0, 0.71, 1.4, 2.09, 2.8}));
  EXPECT_FALSE(stack.is_resampled);
  expect_near(stack.world_from_index.linear.column[2], {0, 0, 0.7});
}

TEST(DicomGeometry, wide_gaps_are_refused_and_named) {
  try {
    stack_slices("a", axials({0, 1, 2, 3, 30, 31, 32}));
    FAIL();
  } catch (const WorkError& error) {
    EXPECT_NE(std::string(error.what()).find("27 mm from 3 mm to 30 mm"), std::string::npos)
        << error.what();
  }
  EXPECT_THROW(stack_slices("a", axials({0, 1, 2.3, 3.1, 9.5})), WorkError);
}

TEST(DicomGeometry, of_slices_at_one_place_the_first_is_kept) {
  const SliceStack stack = stack_slices("a", axials({0, 4, 2, 2, 4, 2}));
  EXPECT_EQ(firsts(stack), (std::vector<std::size_t>{0, 2, 1}));
  EXPECT_EQ(stack.volume_count(), 1);
  EXPECT_TRUE(says(stack, "3 slices lie where another does"));
}

TEST(DicomGeometry, as_many_slices_at_each_place_are_volumes) {
  const SliceStack stack = stack_slices("a", axials({2, 2, 0, 0, 1, 1}));
  EXPECT_EQ(stack.volume_count(), 2);
  EXPECT_EQ(stack.places, (std::vector<std::vector<std::size_t>>{{2, 3}, {4, 5}, {0, 1}}));
  EXPECT_EQ(stack.layers.size(), 3u);
}

TEST(DicomGeometry, localizers_and_other_sizes_are_left_out) {
  std::vector<SlicePlace> slices = axials({0, 1, 2, 3});
  slices[0].axes = {{Vec3{0, 1, 0}, Vec3{0, 0, -1}}};
  slices[2].rows = 5;
  slices.push_back(axial(4));
  const SliceStack stack = stack_slices("a", slices);
  EXPECT_EQ(firsts(stack), (std::vector<std::size_t>{1, 3, 4}));
  EXPECT_TRUE(says(stack, "2 of its 5 slices"));
}

TEST(DicomGeometry, one_slice_takes_its_distance_from_the_file) {
  const SliceStack stack = stack_slices("a", axials({5}));
  expect_near(stack.world_from_index.linear.column[2], {0, 0, 9});
}

TEST(DicomGeometry, slices_that_do_not_say_where_they_lie_keep_their_order) {
  const SliceStack stack = stack_slices("a", {SlicePlace{.columns = 2}, SlicePlace{.columns = 2}});
  EXPECT_EQ(firsts(stack), (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(stack.world_from_index, Affine{});
  EXPECT_TRUE(says(stack, "do not say how they lie"));
  EXPECT_TRUE(says(stack, "1 mm"));
}

TEST(DicomGeometry, senseless_orientations_spacings_and_positions_are_refused) {
  std::vector<SlicePlace> slices = axials({0});
  slices[0].axes = {{Vec3{1, 0, 0}, Vec3{1, 0, 0}}};
  EXPECT_THROW(stack_slices("a", slices), WorkError);
  slices = axials({0});
  slices[0].spacing_mm = {{0, 1}};
  EXPECT_THROW(stack_slices("a", slices), WorkError);
  slices = axials({0, std::nan("")});
  EXPECT_THROW(stack_slices("a", slices), WorkError);
  // In line but for one that is 50 mm aside.
  slices = axials({0, 1, 2, 3});
  slices[2].position->x += 50;
  EXPECT_THROW(stack_slices("a", slices), WorkError);
}

}  // namespace
}  // namespace isolux
