#include "isolux/render/transport.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "isolux/base/parallel.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/render/path_tracer.h"
#include "isolux/render/ray_caster.h"
#include "isolux/render/test_scenes.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

const json kNoLamp = {{"kind", "directional"}, {"to", {0, 0, 1}}, {"intensity", 0}};

// A scene's surfaces, its picture and its transport.
struct Lit {
  Scene scene;
  RayCaster caster;
  SurfaceBuffer buffer;
  Transport transport;
  Indirect indirect;

  explicit Lit(const Scene& of, TransportOptions options = {})
      : scene(of),
        caster(scene),
        buffer(caster.cast(*scene.camera)),
        transport(scene, caster.surfaces(), options) {
    transport.see(scene, buffer);
    EXPECT_TRUE(transport.refine(scene.bounces));
    light(scene);
  }
  void light(const Scene& with) {
    transport.light(with);
    transport.gather(buffer, indirect);
  }
};

json settings_of(const json& surface, const std::vector<json>& lamps, int bounces) {
  return {{"surface", json::array({surface})},
          {"light", lamps},
          {"shadows", "on"},
          {"indirect", "path"},
          {"bounces", bounces}};
}

const json kPointInTheMiddle = {{"kind", "point"}, {"at", {0, 0, 0}}};

// The sphere of radius 16 as an isosurface, and as a mesh.
std::vector<std::pair<SceneInput, json>> spheres(double albedo) {
  const json kd = {albedo, albedo, albedo};
  return {{volume(sphere_phantom()), {{"iso", 0.5}, {"kd", kd}}},
          {mesh(extract_isosurface(sphere_phantom(33), 0.5)), {{"input", 1}, {"kd", kd}}}};
}

TEST(Transport, a_convex_white_body_under_an_even_sky_is_1_everywhere) {
  for (const auto& [input, surface] : spheres(1)) {
    json settings = settings_of(surface, {kNoLamp}, 2);
    settings["ambient"] = {1, 1, 1};
    const Lit lit(scene_of({input}, settings));
    double sum = 0;
    const int hits = each_hit(lit.buffer, [&](std::size_t place) {
      const double e = lit.indirect.pixels.at(place).g;
      sum += e;
      EXPECT_LE(e, 1 + 1e-5);
      EXPECT_GT(e, 0.9);
      EXPECT_LE(lit.indirect.sky[place], 1 + 1e-5);
    });
    EXPECT_GT(hits, 100);
    // Facets of triangles, and voxels, are concave by a hair here and there.
    EXPECT_GT(sum / hits, 0.999);
  }
}

TEST(Transport, a_lamp_in_the_middle_of_a_cavity_adds_a_power_of_the_albedo_at_each_bounce) {
  // Every point of the wall receives I, and what others send is the same all over: after b bounces
  // E = rho + ... + rho^b. Seen from the middle as well, on the inside of the surface.
  constexpr double kAlbedo = 0.7;
  for (const auto& [input, surface] : spheres(kAlbedo)) {
    for (const int bounces : {1, 2, 5}) {
      json settings = settings_of(surface, {kPointInTheMiddle}, bounces);
      settings["camera"] = {{"eye", {0, 0, 0}}, {"target", {1, 2, 1}}, {"fov", 90}};
      const Lit lit(scene_of({input}, settings));
      double expected = 0;
      for (int k = 1; k <= bounces; ++k) expected += std::pow(kAlbedo, k);
      // The lamp's rays meet the wall at n . l = 1 but for the slant of normals, below 0.14: 0.99.
      const int hits = each_hit(lit.buffer, [&](std::size_t place) {
        EXPECT_NEAR(lit.indirect.pixels.at(place).g, expected, 0.01 * bounces * expected);
        EXPECT_EQ(lit.indirect.sky[place], 0);
      });
      EXPECT_EQ(hits, kTestSize * kTestSize);
    }
  }
}

TEST(Transport, zero_bounces_are_dark) {
  const auto [input, surface] = spheres(0.7)[0];
  const Lit lit(scene_of({input}, settings_of(surface, {kPointInTheMiddle}, 0)));
  each_hit(lit.buffer, [&](std::size_t place) { EXPECT_EQ(lit.indirect.pixels.at(place), Rgb{}); });
}

const json kLampA = {{"kind", "point"}, {"at", {-90, -200, 60}}, {"color", {1, 0.5, 0.2}}};
const json kLampB = {{"kind", "directional"}, {"to", {1, -0.2, 0.3}}};

Scene head_scene(const std::vector<json>& lamps, int bounces = 3) {
  return scene_of({volume(head_phantom(48))}, settings_of({{"iso", 300}}, lamps, bounces));
}

TEST(Transport, two_lamps_give_the_sum_of_each_alone_over_the_same_links) {
  Lit lit(head_scene({kLampA, kLampB}));
  const Indirect both = lit.indirect;
  lit.light(head_scene({kLampA}));
  const Indirect first = lit.indirect;
  lit.light(head_scene({kLampB}));
  double brightest = 0;
  each_hit(lit.buffer, [&](std::size_t place) {
    const Rgb sum = first.pixels.at(place) + lit.indirect.pixels.at(place);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(both.pixels.at(place)[c], sum[c], 1e-5);
    brightest = std::max(brightest, sum.r);
  });
  EXPECT_GT(brightest, 0.05);
}

TEST(Transport, a_lamp_that_has_moved_there_lights_as_one_that_was_there) {
  Lit moved(head_scene({kLampB}));
  moved.light(head_scene({kLampA}));
  const Lit there(head_scene({kLampA}));
  each_hit(there.buffer, [&](std::size_t place) {
    EXPECT_EQ(moved.indirect.pixels.at(place), there.indirect.pixels.at(place));
  });
}

TEST(Transport, refining_in_pieces_and_on_any_threads_gives_the_same_bits) {
  const Scene scene = head_scene({kLampA, kLampB});
  std::optional<Lit> whole;
  with_threads(1, [&] { whole.emplace(scene); });
  Lit pieces(scene, {.links = 8});
  with_threads(5, [&] {
    Transport transport(scene, pieces.caster.surfaces());
    transport.see(scene, pieces.buffer);
    for (int asked = 0; !transport.refine(scene.bounces, [&] { return ++asked % 3 == 0; });) {
      EXPECT_LT(transport.done(), 1);
    }
    EXPECT_EQ(transport.done(), 1);
    transport.light(scene);
    transport.gather(pieces.buffer, pieces.indirect);
  });
  each_hit(whole->buffer, [&](std::size_t place) {
    EXPECT_EQ(whole->indirect.pixels.at(place), pieces.indirect.pixels.at(place));
    EXPECT_EQ(whole->indirect.sky[place], pieces.indirect.sky[place]);
  });
}

TEST(Transport, no_bounce_brings_more_light_than_the_one_before_sent) {
  // With an albedo of 1 nothing is lost but to the sky: sky + what surfaces see of each other is 1,
  // so E under an even sky of 1 is at most 1 after any number of bounces, and never falls.
  const json surface = {{"iso", 300}, {"kd", {1, 1, 1}}};
  double last = 0;
  for (const int bounces : {1, 2, 4, 8}) {
    json settings = settings_of(surface, {kNoLamp}, bounces);
    settings["ambient"] = {1, 1, 1};
    const Lit lit(scene_of({volume(head_phantom(48))}, settings));
    double sum = 0;
    each_hit(lit.buffer, [&](std::size_t place) {
      const double e = lit.indirect.pixels.at(place).g;
      EXPECT_LE(e, 1 + 1e-5);
      sum += e;
    });
    EXPECT_GT(sum, last);
    last = sum;
  }
}

TEST(Transport, it_agrees_with_the_path_tracer) {
  json settings = settings_of({{"iso", 300}}, {kLampA, kLampB}, 2);
  settings["spp"] = 2048;
  const Lit lit(scene_of({volume(head_phantom(96))}, settings));
  PathTracer tracer(lit.scene, lit.caster.surfaces());
  tracer.run(lit.buffer);
  const Indirect path = tracer.indirect(lit.buffer);
  double mean = 0, bias = 0, off = 0;
  each_hit(lit.buffer, [&](std::size_t place) {
    const double difference = lit.indirect.pixels.at(place).g - path.pixels.at(place).g;
    mean += path.pixels.at(place).g;
    bias += difference;
    off += std::fabs(difference);
  });
  EXPECT_LT(std::fabs(bias), 0.02 * mean);
  EXPECT_LT(off, 0.12 * mean);
}

TEST(Transport, memory_bounds_its_samples_and_links) {
  const Scene scene = head_scene({kLampA});
  double last = Lit(scene, {.links = 512}).transport.bytes();
  for (const double share : {0.7, 0.5, 0.35}) {
    const double limit = share * last;
    const Lit bound(scene, {.links = 512, .memory = limit});
    EXPECT_LE(bound.transport.bytes(), limit);
  }
}

}  // namespace
}  // namespace isolux
