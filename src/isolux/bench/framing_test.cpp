#include "isolux/bench/framing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isolux {
namespace {

constexpr double kPi = 3.14159265358979323846;

TEST(Framing, TheOrbitStandsWhereTheSphereOfTheBoxJustFits) {
  const Vec3 box{200, 100, 50};
  const double radius = std::sqrt(200. * 200 + 100. * 100 + 50. * 50) / 2;
  for (const double deg : {0., 1., 90., 359.}) {
    const View view = orbit_view(box, deg);
    EXPECT_EQ(view.target, (Vec3{100, 50, 25}));
    const double distance = length(view.eye - view.target);
    EXPECT_NEAR(std::asin(radius / distance) * 180 / kPi, view.fov_deg / 2, 1e-9);
    EXPECT_NEAR((view.eye.z - 25) / distance, 0.2 / std::sqrt(1.04), 1e-12);
  }
}

TEST(Framing, ItBeginsAtMinusYAndTurnsTowardsPlusX) {
  const Vec3 box{100, 100, 100};
  const Vec3 begin = orbit_view(box, 0).eye, quarter = orbit_view(box, 90).eye;
  EXPECT_NEAR(begin.x, 50, 1e-9);
  EXPECT_LT(begin.y, 0);
  EXPECT_GT(quarter.x, 100);
  EXPECT_NEAR(quarter.y, 50, 1e-9);
}

TEST(Framing, TheCloseViewLooksAlongTheOrbitsOwnRayFromNearer) {
  const Vec3 box{245, 245, 160};
  const Vec3 far = orbit_view(box, 30).eye - box / 2, near = close_view(box, 30).eye - box / 2;
  EXPECT_NEAR(length(cross(normalize(far), normalize(near))), 0, 1e-12);
  EXPECT_LT(length(near), length(far) / 2);
}

}  // namespace
}  // namespace isolux
