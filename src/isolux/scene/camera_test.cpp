#include "isolux/scene/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "isolux/base/error.h"

namespace isolux {
namespace {

const BoundingSphere kSphere{{10, 20, 30}, 100};

CameraDescription view(const char* name) { return {.view = name}; }

void expect_near(Vec3 a, Vec3 b) {
  EXPECT_LT(length(a - b), 1e-12) << a.x << " " << a.y << " " << a.z;
}

TEST(Camera, named_views_look_from_where_their_name_says) {
  // LPS: +x is the patient's left, +y posterior, +z superior. Right in the picture, and back.
  const struct {
    const char* name;
    Vec3 right, up, back;
  } kViews[] = {
      {"front", {1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {"back", {-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
      {"left", {0, 1, 0}, {0, 0, 1}, {1, 0, 0}},   {"right", {0, -1, 0}, {0, 0, 1}, {-1, 0, 0}},
      {"top", {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}},  {"bottom", {1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
  };
  for (const auto& expected : kViews) {
    const Affine camera = Camera(view(expected.name), 64, 64, kSphere).world_from_camera();
    expect_near(camera.linear.column[0], expected.right);
    expect_near(camera.linear.column[1], expected.up);
    expect_near(camera.linear.column[2], expected.back);
  }
}

TEST(Camera, a_named_view_just_fits_the_sphere_in_the_narrower_direction) {
  for (const auto& [width, height] :
       {std::pair{100, 100}, std::pair{200, 100}, std::pair{100, 200}}) {
    const Camera camera(view("front"), width, height, kSphere);
    const Vec3 eye = camera.world_from_camera().offset;
    // Half the vertical angle is 15 degrees; across a picture half as wide, its tangent is halved.
    const double half =
        std::atan(std::tan(15 * M_PI / 180) * std::min(1.0, width / double(height)));
    EXPECT_NEAR(length(eye - kSphere.center), 100 / std::sin(half), 1e-9);
  }
}

TEST(Camera, rays_pass_through_pixel_centres_and_row_0_is_the_top) {
  const Camera camera({.eye = Vec3{0, 0, 0}, .target = Vec3{0, 1, 0}, .up = Vec3{0, 0, 1}}, 4, 2,
                      kSphere);
  // Half the height at distance 1 is tan 15; the top left pixel's centre is 1.5 pixels to the left
  // of the middle and half a pixel above it, and a pixel is tan 15 high.
  const double pixel = std::tan(15 * M_PI / 180);
  expect_near(camera.ray(0, 0).direction, normalize({-1.5 * pixel, 1, 0.5 * pixel}));
  expect_near(camera.ray(3, 1).direction, normalize({1.5 * pixel, 1, -0.5 * pixel}));
  EXPECT_NEAR(length(camera.ray(2, 1).direction), 1, 1e-15);
}

TEST(Camera, an_orthographic_camera_sends_parallel_rays_from_its_plane) {
  const Camera camera({.view = "front", .orthographic = true, .height_mm = 20}, 10, 10, kSphere);
  const Ray ray = camera.ray(9, 0);
  expect_near(ray.direction, {0, 1, 0});
  EXPECT_NEAR(ray.origin.x, 10 + 9, 1e-12);  // 4.5 pixels of 2 mm to the right of the middle
  EXPECT_NEAR(ray.origin.z, 30 + 9, 1e-12);
  EXPECT_LE(ray.origin.y, 20 - 100);  // before everything
}

TEST(Camera, an_orthographic_view_shows_the_whole_sphere) {
  for (const auto& [width, height] : {std::pair{10, 10}, std::pair{20, 10}, std::pair{10, 20}}) {
    const Camera camera({.view = "top", .orthographic = true}, width, height, kSphere);
    const double pixel = length(camera.ray(1, 0).origin - camera.ray(0, 0).origin);
    EXPECT_NEAR(std::min(width, height) * pixel, 200, 1e-9);
  }
}

TEST(Camera, an_eye_that_sees_nothing_is_refused) {
  EXPECT_THROW(Camera({.eye = Vec3{1, 1, 1}, .target = Vec3{1, 1, 1}}, 4, 4, kSphere), UsageError);
  EXPECT_THROW(Camera({.eye = Vec3{0, 0, 9}, .target = Vec3{0, 0, 0}}, 4, 4, kSphere), UsageError);
}

}  // namespace
}  // namespace isolux
