#include "isolux/volume/cell.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace isolux {
namespace {

// a + b x + c y + d z + e x y + f x z + g y z + h x y z, and its derivatives.
struct Trilinear {
  double a, b, c, d, e, f, g, h;

  double at(Vec3 p) const {
    return a + b * p.x + c * p.y + d * p.z + e * p.x * p.y + f * p.x * p.z + g * p.y * p.z +
           h * p.x * p.y * p.z;
  }
  Vec3 gradient(Vec3 p) const {
    return {b + e * p.y + f * p.z + h * p.y * p.z, c + e * p.x + g * p.z + h * p.x * p.z,
            d + f * p.x + g * p.y + h * p.x * p.y};
  }
  CellCorners corners() const {
    CellCorners values{};
    for (int n = 0; n < 8; ++n) {
      values[static_cast<std::size_t>(n)] =
          at({static_cast<double>(n & 1), static_cast<double>(n >> 1 & 1),
              static_cast<double>(n >> 2)});
    }
    return values;
  }
};

constexpr Trilinear kField{3, -2, 5, 0.5, 4, -1, 2, -7};

TEST(Cell, the_interpolant_is_the_trilinear_polynomial_of_its_corners) {
  for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 1, 1}, Vec3{.3, .6, .9}, Vec3{.5, 0, 1}}) {
    EXPECT_NEAR(interpolate(kField.corners(), p), kField.at(p), 1e-14);
    EXPECT_NEAR(length(interpolant_gradient(kField.corners(), p) - kField.gradient(p)), 0, 1e-13);
  }
}

TEST(Cell, a_face_of_zeros_interpolates_to_exactly_zero) {
  const CellCorners corners{0.1, 0, 0.7, 0, -1e3, 0, 1e-9, 0};  // zero where x = 1
  EXPECT_EQ(interpolate(corners, {1, 0.37, 0.91}), 0);
}

TEST(Cell, two_cells_agree_on_their_common_face_to_the_last_bit) {
  const CellCorners left{0.1, 0.7, 1e5, -0.3, 1e-7, 3.3, 8.1, 1e3};
  const CellCorners right{0.7, 5, -0.3, 1e9, 3.3, -2, 1e3, 7};
  for (double y = 0; y <= 1; y += 0.0625) {
    EXPECT_EQ(interpolate(left, {1, y, 0.3}), interpolate(right, {0, y, 0.3}));
  }
}

TEST(Cell, central_differences_are_one_sided_at_the_border) {
  const std::vector<float> squares{0, 1, 4, 9, 0, 1, 4, 9, 0, 1, 4, 9, 0, 1, 4, 9};
  const VolumeView<float> view{squares.data(), {4, 2, 2}};
  EXPECT_EQ(central_difference(view, 0, 0, 0), (Vec3{1, 0, 0}));
  EXPECT_EQ(central_difference(view, 1, 0, 0), (Vec3{2, 0, 0}));  // (4 - 0) / 2
  EXPECT_EQ(central_difference(view, 3, 1, 1), (Vec3{5, 0, 0}));
}

TEST(Cell, the_blended_gradient_is_nothing_where_it_vanishes_or_is_not_finite) {
  std::vector<float> peak{0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};  // symmetric about i = 1
  const VolumeView<float> view{peak.data(), {3, 2, 2}};
  EXPECT_EQ(blended_gradient(view, {0, 0, 0}, {1, 0.4, 0.7}), std::nullopt);
  EXPECT_EQ(blended_gradient(view, {0, 0, 0}, {0, 0, 0}), (Vec3{1, 0, 0}));
  peak[2] = std::numeric_limits<float>::quiet_NaN();  // a neighbour outside the cell
  EXPECT_EQ(blended_gradient(view, {0, 0, 0}, {0.5, 0, 0}), std::nullopt);
}

}  // namespace
}  // namespace isolux
