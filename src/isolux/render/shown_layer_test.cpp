#include "isolux/render/shown_layer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "isolux/scene/document.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

// The sphere of radius 16 mm, seen from the front (eye at -y) without perspective, 32 mm high: its
// middle is at pixel (16, 16), less half a pixel.
Scene sphere_scene(const json& lights, const json& settings = json::object()) {
  json document = empty_document();
  document["size"] = {33, 33};
  document["surface"] = {{{"iso", 0.5}}};
  document["camera"] = {{"projection", "orthographic"}, {"height", 40}};
  document["background"] = {0.2, 0.2, 0.2};
  document["light"] = lights;
  document.update(settings);
  SceneDescription description = describe(document, "scene");
  description.inputs = {"phantom:sphere"};
  return resolve(description, {{std::make_shared<Volume>(sphere_phantom())}});
}

std::array<int, 3> at(const Picture& picture, int x, int y) {
  const auto* rgb = &picture.rgb[static_cast<std::size_t>(3 * (y * picture.width + x))];
  return {rgb[0], rgb[1], rgb[2]};
}

TEST(ShownLayer, a_normal_towards_the_eye_is_shown_as_half_one_half_zero_half) {
  // From the front n = (0, -1, 0), shown as (n + 1) / 2.
  Session session;
  const Scene scene = sphere_scene({{{"kind", "directional"}, {"to", {0, -1, 0}}}});
  const ShownPicture shown = show_layer(ShownLayer::kNormal, scene, 0, session);
  const auto middle = at(shown.picture, 16, 16);
  EXPECT_NEAR(middle[0], 127.5, 1);
  EXPECT_NEAR(middle[1], 0, 1);
  EXPECT_NEAR(middle[2], 127.5, 1);
}

TEST(ShownLayer, cosines_are_those_of_the_chosen_lamp) {
  // cos theta is 1 for a lamp at the eye, -1 for one behind: the two ends of the legend.
  Session session;
  const Scene scene = sphere_scene({{{"kind", "directional"}, {"to", {0, -1, 0}}},
                                    {{"kind", "directional"}, {"to", {0, 1, 0}}}});
  for (const std::size_t light : {0u, 1u}) {
    const ShownPicture shown = show_layer(ShownLayer::kCosTheta, scene, light, session);
    const auto& end = light == 0 ? shown.legend->colors.back() : shown.legend->colors.front();
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(at(shown.picture, 16, 16)[c], end[c], 1);
  }
}

TEST(ShownLayer, depth_runs_from_the_nearest_to_the_farthest_point_that_is_seen) {
  // The sphere's depths span its radius, less what the outermost pixel's centre leaves.
  Session session;
  const Scene scene = sphere_scene({{{"kind", "directional"}, {"to", {0, -1, 0}}}});
  const ShownPicture shown = show_layer(ShownLayer::kDepth, scene, 0, session);
  EXPECT_GT(shown.legend->high - shown.legend->low, 9);
  EXPECT_LT(shown.legend->high - shown.legend->low, 16.5);
  const auto& near = shown.legend->colors.front();
  EXPECT_EQ(at(shown.picture, 16, 16), (std::array<int, 3>{near[0], near[1], near[2]}));
}

TEST(ShownLayer, every_layer_shows_the_background_where_nothing_is_met) {
  Session session;
  const Scene scene = sphere_scene({{{"kind", "point"}, {"at", {0, -60, 57}}}});
  const auto background = displayed(scene.display, scene.background);
  for (const char* name : {"picture", "direct", "ambient", "diffuse", "specular", "indirect",
                           "cos-theta", "cos-phi", "normal", "depth"}) {
    const ShownPicture shown = show_layer(*shown_layer_named(name), scene, 0, session);
    EXPECT_EQ(at(shown.picture, 0, 0)[0], background[0]) << name;
  }
  EXPECT_FALSE(shown_layer_named("sky"));
}

TEST(ShownLayer, direct_is_the_picture_without_ambient_and_indirect_light) {
  // What is left where nothing comes by way of other surfaces, in mirrors and behind veils too.
  const json surfaces = {{{"iso", 0.7}, {"kr", {0.5, 0.5, 0.5}}}, {{"iso", 0.4}, {"opacity", 0.5}}};
  const json lamp = {{{"kind", "point"}, {"at", {0, -60, 57}}}};
  const Scene without = sphere_scene(lamp, {{"surface", surfaces}, {"ambient", {0, 0, 0}}});
  Session alone;
  const Picture& wanted = alone.picture(without);
  for (const char* method : {"off", "path"}) {
    Session session;
    const Scene scene = sphere_scene(
        lamp, {{"surface", surfaces}, {"ambient", {0.5, 0.5, 0.5}}, {"indirect", method}});
    const auto before = session.picture(scene).rgb;
    EXPECT_EQ(show_layer(ShownLayer::kDirect, scene, 0, session).picture.rgb, wanted.rgb);
    EXPECT_NE(before, wanted.rgb);
    // Side by side, neither makes the other be found again.
    EXPECT_EQ(session.picture(scene).rgb, before);
    session.radiance(scene);
    EXPECT_EQ(session.counters().indirect, method == std::string("path") ? 1 : 0);
    EXPECT_EQ(session.counters().lighting, 3);
  }
}

TEST(ShownLayer, the_terms_add_up_to_the_picture) {
  // With the raw display and no clamping, bytes add up to one byte for each of the three roundings.
  Scene scene = sphere_scene({{{"kind", "point"}, {"at", {0, -60, 57}}, {"intensity", 0.5}}});
  scene.display.curve = Display::Curve::kRaw;
  Session session;
  int sum = 0;
  for (const ShownLayer layer :
       {ShownLayer::kAmbient, ShownLayer::kDiffuse, ShownLayer::kSpecular}) {
    sum += at(show_layer(layer, scene, 0, session).picture, 16, 12)[0];
  }
  EXPECT_NEAR(sum, at(session.picture(scene), 16, 12)[0], 2);
  EXPECT_GT(sum, 20);
}

}  // namespace
}  // namespace isolux
