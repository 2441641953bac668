#include "isolux/render/seen.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "isolux/render/session.h"
#include "isolux/scene/document.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

// A ball of 16 mm round the origin, seen from the front without perspective in a picture of 80 mm
// and 100 pixels: a pixel is 0.8 mm.
Scene ball_in_front(double iso = 0.5) {
  nlohmann::json document = empty_document();
  document["size"] = {100, 100};
  document["surface"] = {{{"iso", iso}}};
  document["camera"] = {{"view", "front"}, {"projection", "orthographic"}, {"height", 80}};
  SceneDescription description = describe(document, "scene");
  description.inputs = {"phantom:sphere"};
  return resolve(description, {{std::make_shared<Volume>(sphere_phantom())}});
}

TEST(Seen, a_ball_in_the_middle_takes_its_diameter_of_the_picture) {
  Session session;
  const auto part = seen_part(session.surfaces(ball_in_front()));
  ASSERT_TRUE(part);
  // 32 of 80 mm are 0.4 of the picture, from 0.3 to 0.7; pixels are met at their centres.
  for (const double low : {part->left, part->top}) EXPECT_NEAR(low, 0.3, 0.0101);
  for (const double high : {part->right, part->bottom}) EXPECT_NEAR(high, 0.7, 0.0101);
}

TEST(Seen, where_nothing_is_met_nothing_is_seen) {
  Session session;
  const Scene scene = ball_in_front(0.999999);  // a ball of 0.00003 mm, between two pixels
  EXPECT_FALSE(seen_part(session.surfaces(scene)));
  EXPECT_FALSE(nearest_seen(*scene.camera, session.surfaces(scene), {0, -60, 0}));
}

TEST(Seen, the_nearest_point_of_a_ball_lies_on_the_line_to_its_middle) {
  Session session;
  const Scene scene = ball_in_front();
  const SurfaceBuffer& buffer = session.surfaces(scene);
  for (const Vec3 lamp : {Vec3{0, -60, 0}, Vec3{25, -40, -10}, Vec3{-40, -20, 30}}) {
    const auto foot = nearest_seen(*scene.camera, buffer, lamp);
    ASSERT_TRUE(foot);
    const Vec3 expected = 16 * normalize(lamp);
    // Half a pixel across, and as much again along the slope of the ball.
    EXPECT_LT(length(*foot - expected), 1.2) << lamp.x;
  }
}

}  // namespace
}  // namespace isolux
