#include "isolux/shade/reflection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace isolux {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr SurfacePoint kFloor{{0, 0, 0}, {0, 0, 1}, {0, 0, 1}};  // seen from straight above

Vec3 tilted(double degrees) {
  return {std::sin(degrees * kDegree), 0, std::cos(degrees * kDegree)};
}
Light sun(Vec3 to, Rgb intensity = {1, 1, 1}) {
  return {Light::Kind::kDirectional, to, intensity, {}};
}
Light lamp(Vec3 at, Rgb intensity = {1, 1, 1}) { return {Light::Kind::kPoint, at, intensity, {}}; }

TEST(Reflection, the_diffuse_term_follows_the_cosine_law) {
  const Material chalk{{}, {0.8, 0.8, 0.8}, {}, 1};
  for (const double degrees : {0.0, 30.0, 45.0, 60.0, 90.0}) {
    const LightTerms t = light_terms(chalk, sun(tilted(degrees)), kFloor);
    EXPECT_NEAR(t.diffuse.r, 0.8 * std::cos(degrees * kDegree), 1e-15) << degrees;
  }
}

TEST(Reflection, a_light_behind_the_surface_adds_nothing) {
  const LightTerms t = light_terms(Material{}, sun(tilted(120)), kFloor);
  EXPECT_NEAR(t.cos_theta, -0.5, 1e-15);  // told unclamped
  EXPECT_EQ(t.diffuse, Rgb{});
  EXPECT_EQ(t.specular, Rgb{});
}

TEST(Reflection, white_light_on_a_red_surface_is_red_and_red_light_on_a_blue_one_is_black) {
  const Material red{{}, {1, 0, 0}, {}, 1};
  EXPECT_EQ(light_terms(red, sun({0, 0, 1}), kFloor).diffuse, (Rgb{1, 0, 0}));
  const Material blue{{}, {0, 0, 1}, {}, 1};
  EXPECT_EQ(light_terms(blue, sun({0, 0, 1}, {1, 0, 0}), kFloor).diffuse, (Rgb{0, 0, 0}));
  EXPECT_EQ(ambient_term({{0.1, 0.2, 0.3}, {}, {}, 1}, {1, 2, 3}), (Rgb{0.1, 0.4, 0.3 * 3}));
}

TEST(Reflection, phong_is_the_cosine_to_the_mirror_direction_to_the_power_of_shininess) {
  for (const double shininess : {1.0, 10.0, 100.0, 1000.0}) {
    const Material shiny{{}, {}, {0.3, 0.3, 0.3}, shininess};
    for (const double degrees : {0.0, 2.0, 5.0, 20.0, 60.0}) {
      // The light 20 degrees to one side is mirrored 20 to the other; the eye is `degrees` off it.
      const SurfacePoint point{{}, {0, 0, 1}, tilted(-20 + degrees)};
      const LightTerms t = light_terms(shiny, sun(tilted(20)), point);
      const double expected = 0.3 * std::pow(std::cos(degrees * kDegree), shininess);
      EXPECT_NEAR(t.specular.g, expected, 1e-12) << degrees << " " << shininess;
    }
  }
}

TEST(Reflection, as_shininess_grows_only_the_mirror_direction_stays) {
  const Material mirror{{}, {}, {1, 1, 1}, 1e6};
  const LightTerms at = light_terms(mirror, sun(tilted(20)), {{}, {0, 0, 1}, tilted(-20)});
  const LightTerms beside = light_terms(mirror, sun(tilted(20)), {{}, {0, 0, 1}, tilted(-21)});
  EXPECT_NEAR(at.specular.r, 1, 1e-9);
  EXPECT_LT(beside.specular.r, 1e-60);  // cos(1 degree)^1e6 = e^-152
}

TEST(Reflection, the_mirrored_vector_lies_in_the_plane_of_n_and_l_at_the_same_angle) {
  const LightTerms t = light_terms(Material{}, lamp({3, -2, 5}),
                                   {{1, 1, 1}, normalize({1, 2, 3}), normalize({0, 1, 1})});
  const Vec3 n = normalize({1, 2, 3});
  EXPECT_NEAR(dot(t.reflected, n), t.cos_theta, 1e-15);
  EXPECT_NEAR(length(t.reflected), 1, 1e-15);
  EXPECT_NEAR(dot(cross(n, t.to_light), t.reflected), 0, 1e-15);
}

TEST(Reflection, a_point_light_is_seen_along_the_unit_vector_to_it) {
  const LightTerms t =
      light_terms(Material{}, lamp({0, 0, 57}), {{-3, 0, 53}, {0, 0, 1}, {0, 0, 1}});
  EXPECT_EQ(t.offset, (Vec3{3, 0, 4}));
  EXPECT_EQ(t.distance, 5);
  EXPECT_EQ(t.to_light, (Vec3{0.6, 0, 0.8}));
}

TEST(Reflection, inverse_square_falloff_is_one_at_its_reference_and_a_quarter_at_twice_it) {
  for (const double distance : {1000.0, 2000.0}) {
    Light light = lamp({0, 0, distance});
    light.inverse_square_reference_mm = 1000;
    const LightTerms t = light_terms({{}, {1, 1, 1}, {}, 1}, light, kFloor);
    EXPECT_NEAR(t.diffuse.r, distance == 1000 ? 1 : 0.25, 1e-15);
  }
}

TEST(Reflection, a_light_in_the_surface_itself_adds_nothing_and_no_nan) {
  Light light = lamp(kFloor.position);
  light.inverse_square_reference_mm = 1000;
  const LightTerms t = light_terms(Material{}, light, kFloor);
  EXPECT_EQ(t.diffuse, Rgb{});
  EXPECT_EQ(t.specular, Rgb{});
}

}  // namespace
}  // namespace isolux
