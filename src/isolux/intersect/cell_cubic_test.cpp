#include "isolux/intersect/cell_cubic.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isolux {
namespace {

// Corner values of a field that is `low` where x = 0 and `high` where x = 1.
CellCorners ramp_in_x(double low, double high) {
  return {low, high, low, high, low, high, low, high};
}

// Values only where x = y: +peak there, -rest elsewhere, the same at both z.
CellCorners diagonal_sheet(double peak, double rest) {
  return {peak, -rest, -rest, peak, peak, -rest, -rest, peak};
}

TEST(CellCubic, a_ramp_is_zero_where_it_should_be) {
  const auto s = first_zero(ramp_in_x(-1, 3), {{0, 0.2, 0.7}, {1, 0.9, 0.1}});
  ASSERT_TRUE(s);
  EXPECT_NEAR(*s, 0.25, 1e-15);
}

TEST(CellCubic, a_field_without_zero_has_none) {
  EXPECT_FALSE(first_zero(ramp_in_x(1, 3), {{0, 0, 0}, {1, 1, 1}}));
}

TEST(CellCubic, a_pair_of_crossings_inside_one_cell_is_found) {
  // Across the sheet, from corner (1, 0) to (0, 1): f = (peak + rest) 2 s (1 - s) - rest.
  for (const double rest : {0.5, 0.9, 0.99, 0.999999}) {
    const auto s = first_zero(diagonal_sheet(1, rest), {{1, 0, 0.5}, {0, 1, 0.5}});
    const double expected = 0.5 - std::sqrt(0.25 - rest / (2 * (1 + rest)));
    ASSERT_TRUE(s) << rest;
    EXPECT_NEAR(*s, expected, 1e-9);
  }
}

TEST(CellCubic, a_pair_that_misses_by_a_hair_is_none) {
  // The top at s = 1/2 is (1 + rest) / 2 - rest, below zero where rest > 1.
  EXPECT_FALSE(first_zero(diagonal_sheet(1, 1.000001), {{1, 0, 0.5}, {0, 1, 0.5}}));
}

TEST(CellCubic, of_three_crossings_the_first_is_taken) {
  // Along the diagonal of the cell, x = y = z = s: the cubic (s - .2) (s - .5) (s - .8), given by
  // its polar form at the corners (how many of the three arguments are 1).
  const auto polar = [](double ones) {  // s^3 -> [3 ones], s^2 -> pairs / 3, s -> ones / 3
    const double pairs = ones == 3 ? 1 : ones == 2 ? 1.0 / 3 : 0;
    return (ones == 3 ? 1.0 : 0) - 1.5 * pairs + 0.66 * ones / 3 - 0.08;
  };
  CellCorners corners{};
  for (int n = 0; n < 8; ++n) {
    corners[static_cast<std::size_t>(n)] = polar((n & 1) + (n >> 1 & 1) + (n >> 2));
  }
  const auto s = first_zero(corners, {{0, 0, 0}, {1, 1, 1}});
  ASSERT_TRUE(s);
  EXPECT_NEAR(*s, 0.2, 1e-12);
}

TEST(CellCubic, a_cell_of_zeros_is_met_on_entry_but_not_at_the_rays_own_origin) {
  const CellCorners zeros{};
  EXPECT_EQ(first_zero(zeros, {{0.1, 0.2, 0.3}, {1, 1, 1}}), 0.0);
  EXPECT_NE(first_zero(zeros, {{0.1, 0.2, 0.3}, {1, 1, 1}, true}), 0.0);
}

TEST(CellCubic, a_zero_on_the_exit_face_counts) {
  EXPECT_EQ(first_zero(ramp_in_x(-1, 0), {{0, 0.3, 0.3}, {1, 0.8, 0.1}}), 1.0);
}

}  // namespace
}  // namespace isolux
