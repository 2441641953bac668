#include "isolux/render/path_tracer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "isolux/base/parallel.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/render/explanation.h"
#include "isolux/render/ray_caster.h"
#include "isolux/render/relight.h"
#include "isolux/render/session.h"
#include "isolux/render/test_scenes.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;
using std::numbers::pi;

const json kNoLamp = {{{"kind", "directional"}, {"to", {0, 0, 1}}, {"intensity", 0}}};

const json kNear = {{"projection", "orthographic"}, {"height", 36}};

struct Traced {
  SurfaceBuffer buffer;
  Indirect indirect;
  Radiance radiance;
};

Traced traced(const Scene& scene) {
  const RayCaster caster(scene);
  SurfaceBuffer buffer = caster.cast(*scene.camera);
  PathTracer tracer(scene, caster.surfaces());
  tracer.run(buffer);
  Indirect indirect = tracer.indirect(buffer);
  Radiance radiance = light(scene, buffer, {}, indirect);
  return {std::move(buffer), std::move(indirect), std::move(radiance)};
}

json surface(json fields) {
  fields["ks"] = {0, 0, 0};
  return fields;
}

// The sphere of radius 16 as an isosurface, and as a mesh.
std::vector<std::pair<SceneInput, json>> spheres(double albedo) {
  const json kd = {albedo, albedo, albedo};
  const Volume phantom = sphere_phantom(33);
  return {{volume(sphere_phantom()), surface({{"iso", 0.5}, {"kd", kd}})},
          {mesh(extract_isosurface(phantom, 0.5)), surface({{"input", 1}, {"kd", kd}})}};
}

TEST(PathTracer, a_convex_white_body_under_an_even_sky_is_1_everywhere) {
  // No direction above the surface meets it again; one that would dip below is reflected.
  for (const auto& [input, item] : spheres(1)) {
    const Scene scene = scene_of({input}, {{"surface", {item}},
                                           {"light", kNoLamp},
                                           {"ambient", {1, 1, 1}},
                                           {"indirect", "path"},
                                           {"camera", kNear},
                                           {"spp", 16}});
    const Traced picture = traced(scene);
    double least = 1, sum = 0;
    const int hits = each_hit(picture.buffer, [&](std::size_t place) {
      const double total = picture.radiance.total.at(place).g;
      least = std::min(least, total);
      sum += total;
      EXPECT_LE(total, 1 + 1e-6);
      EXPECT_EQ(picture.radiance.ambient.at(place).g, 0);
    });
    EXPECT_GT(hits, 500);
    // Facets of triangles, and voxels, are concave by a hair here and there.
    EXPECT_GT(sum / hits, 0.9999);
    EXPECT_GT(least, 0.9);
  }
}

TEST(PathTracer, a_lamp_in_the_middle_of_a_cavity_adds_a_power_of_the_albedo_at_each_bounce) {
  // Every point of the wall receives I, and what others send is the same all over: after b bounces
  // kd E = rho^2 + ... + rho^(b+1). Seen from the middle as well.
  constexpr double kAlbedo = 0.7;
  for (const auto& [input, item] : spheres(kAlbedo)) {
    for (const int bounces : {1, 2, 5}) {
      const Scene scene =
          scene_of({input}, {{"surface", {item}},
                             {"light", {{{"kind", "point"}, {"at", {0, 0, 0}}}}},
                             {"shadows", "on"},
                             {"indirect", "path"},
                             {"bounces", bounces},
                             {"spp", 64},
                             {"camera", {{"eye", {0, 0, 0}}, {"target", {1, 2, 1}}, {"fov", 90}}}});
      double expected = 0;
      for (int k = 2; k <= bounces + 1; ++k) expected += std::pow(kAlbedo, k);
      const Traced picture = traced(scene);
      // Where a ray grazes the wall, its shading normal may be turned round, to a side that the
      // lamp does not reach: a sample or two in a thousand, so up to three in some of the
      // pixels' 64.
      double sum = 0;
      const int hits = each_hit(picture.buffer, [&](std::size_t place) {
        const double found = picture.radiance.indirect.at(place).g;
        EXPECT_NEAR(found, expected, 3.0 / 64 * expected);
        sum += found;
      });
      EXPECT_NEAR(sum / hits, expected, 0.005 * bounces * expected);
      EXPECT_EQ(hits, kTestSize * kTestSize);
    }
  }
}

// The share of open sky at the pixel that looks straight down on (0, 0, height of the floor).
double open_sky(const std::vector<SceneInput>& inputs, json settings, double x) {
  settings["size"] = {1, 1};
  settings["light"] = kNoLamp;
  settings["ambient"] = {1, 1, 1};
  settings["indirect"] = "path";
  settings["bounces"] = 1;
  settings["spp"] = 16384;
  settings["camera"] = {
      {"eye", {x, 0.01, -30 + 1.0}}, {"target", {x, 0.01, -30}}, {"up", {0, 1, 0}}, {"fov", 0.01}};
  const Traced picture = traced(scene_of(inputs, settings));
  const std::size_t place = picture.buffer.at(0, 0);
  EXPECT_TRUE(picture.buffer.is_hit(place));
  EXPECT_EQ(picture.buffer.surface[place], static_cast<std::int32_t>(inputs.size()) - 1);
  return picture.indirect.sky[place];
}

TEST(PathTracer, a_sphere_above_a_plane_hides_its_radius_over_its_distance_squared_of_the_sky) {
  // Points of 16,384 Owen-scrambled samples are off by some 16384^(-3/4) = 7e-4 of the edge.
  for (const auto& [input, item] : spheres(0.5)) {
    const double sky = open_sky({input, mesh(square(-30, 4000, false))}, {{"surface", {item}}}, 0);
    EXPECT_NEAR(sky, 1 - 16.0 * 16 / (30 * 30), 2e-3);
  }
}

TEST(PathTracer, patches_hide_the_sky_by_their_form_factors) {
  // From a point beneath the middle of a parallel square of half edge a at distance h, with
  // s = a / sqrt(h^2 + a^2): F = 4/(2 pi) * 2 s atan(s) (Howell, A Catalog of Radiation Heat
  // Transfer Configuration Factors, B-4, four times).
  const double a = 25, h = 50, s = a / std::hypot(a, h);
  const double parallel = 4 / (2 * pi) * 2 * s * std::atan(s);
  EXPECT_NEAR(open_sky({mesh(square(-30 + h, a, true)), mesh(square(-30, 4000, false))}, {}, 0),
              1 - parallel, 2e-3);
  // Beside a perpendicular wall of height c and half width b at distance d (B-5, twice):
  // F = 2/(2 pi) (atan(b/d) - d/r atan(b/r)), r = hypot(d, c).
  const double b = 60, c = 40, d = 20, r = std::hypot(d, c);
  const double perpendicular = 2 / (2 * pi) * (std::atan(b / d) - d / r * std::atan(b / r));
  Mesh wall = square(0, 1, false);
  const double y[] = {-b, b, b, -b}, z[] = {-30, -30, -30 + c, -30 + c};
  for (std::size_t n = 0; n < 4; ++n) {
    wall.positions[n] = {static_cast<float>(d), static_cast<float>(y[n]), static_cast<float>(z[n])};
  }
  EXPECT_NEAR(open_sky({mesh(wall), mesh(square(-30, 4000, false))}, {}, 0), 1 - perpendicular,
              2e-3);
}

json room(const json& lamps) {
  return {{"size", {24, 24}},
          {"surface", {surface({{"iso", -300}}), surface({{"iso", 300}})}},
          {"light", lamps},
          {"shadows", "on"},
          {"indirect", "path"},
          {"bounces", 3},
          {"spp", 8}};
}

TEST(PathTracer, two_lamps_give_the_sum_of_each_alone) {
  const SceneInput head = volume(head_phantom(48));
  const json a = {{"kind", "point"}, {"at", {-90, -200, 60}}, {"color", {1, 0.5, 0.2}}};
  const json b = {{"kind", "directional"}, {"to", {1, -0.2, 0.3}}};
  const Traced both = traced(scene_of({head}, room(json::array({a, b}))));
  const Traced first = traced(scene_of({head}, room(json::array({a}))));
  const Traced second = traced(scene_of({head}, room(json::array({b}))));
  double brightest = 0;
  each_hit(both.buffer, [&](std::size_t place) {
    const Rgb sum = first.indirect.pixels.at(place) + second.indirect.pixels.at(place);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(both.indirect.pixels.at(place)[c], sum[c], 1e-6);
    brightest = std::max(brightest, sum.r);
  });
  EXPECT_GT(brightest, 0.05);
}

TEST(PathTracer, samples_added_in_pieces_and_on_any_threads_give_the_same_bits) {
  const Scene scene =
      scene_of({volume(head_phantom(48))}, room({{{"kind", "point"}, {"at", {-90, -200, 60}}},
                                                 {{"kind", "directional"}, {"to", {1, 0, 0}}}}));
  const RayCaster caster(scene);
  const SurfaceBuffer buffer = caster.cast(*scene.camera);
  PathTracer whole(scene, caster.surfaces()), pieces(scene, caster.surfaces());
  with_threads(1, [&] { whole.add_samples(buffer, 0, 12); });
  with_threads(5, [&] {
    pieces.add_samples(buffer, 0, 1);
    pieces.add_samples(buffer, 1, 6);
    pieces.add_samples(buffer, 7, 5);
  });
  const Indirect one = whole.indirect(buffer), other = pieces.indirect(buffer);
  each_hit(buffer, [&](std::size_t place) {
    EXPECT_EQ(one.pixels.at(place), other.pixels.at(place));
    EXPECT_EQ(one.sky[place], other.sky[place]);
  });
}

TEST(PathTracer, the_bounces_that_an_explanation_tells_add_up_to_the_light_of_the_picture) {
  for (const char* method : {"path", "transport"}) {
    json settings = room({{{"kind", "point"}, {"at", {-90, -200, 60}}}});
    settings["indirect"] = method;
    if (settings["indirect"] == "transport") settings.erase("spp");
    const Scene scene = scene_of({volume(head_phantom(48))}, settings);
    Session session;
    const Radiance& radiance = session.radiance(scene);
    const SurfaceBuffer& buffer = session.surfaces(scene);
    int compared = 0;
    each_hit(buffer, [&](std::size_t place) {
      if (place % 5 != 0) return;
      ++compared;
      const auto [x, y] = buffer.pixel(place);
      const Explanation e = explain(scene, x, y);
      Rgb parts;
      for (const Rgb& part : e.by_bounce) parts = parts + part;
      EXPECT_EQ(e.by_bounce.size(), 3u);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(parts[c], e.layers[0].terms.irradiance[c], 1e-6);
        EXPECT_NEAR(e.layers[0].terms.indirect[c], radiance.indirect.at(place)[c], 1e-6) << method;
      }
    });
    EXPECT_GT(compared, 2) << method;
  }
}

TEST(PathTracer, an_asked_for_error_is_reached_with_more_samples) {
  json settings = room({{{"kind", "point"}, {"at", {-90, -200, 60}}}});
  settings.erase("spp");
  int last = 0;
  for (const double error : {0.5, 0.1, 0.05}) {
    settings["error"] = error;
    const Scene scene = scene_of({volume(head_phantom(48))}, settings);
    const RayCaster caster(scene);
    const SurfaceBuffer buffer = caster.cast(*scene.camera);
    PathTracer tracer(scene, caster.surfaces());
    tracer.run(buffer);
    EXPECT_LE(tracer.relative_error(), error);
    EXPECT_GE(tracer.samples(), last);
    last = tracer.samples();
  }
  EXPECT_GT(last, 16);
}

TEST(PathTracer, a_pixels_variance_is_that_of_the_samples_it_has) {
  // Under an even sky of 1, with black surfaces and no lamps, a sample is 1 where it sees the sky
  // and 0 elsewhere: of n with the mean p the mean has the variance p (1 - p) / (n - 1).
  json settings = {{"surface", {surface({{"iso", -300}, {"kd", {0, 0, 0}}})}},
                   {"light", kNoLamp},
                   {"ambient", {1, 1, 1}},
                   {"indirect", "path"},
                   {"spp", 8}};
  const Scene scene = scene_of({volume(head_phantom(48))}, settings);
  const RayCaster caster(scene);
  const SurfaceBuffer buffer = caster.cast(*scene.camera);
  PathTracer tracer(scene, caster.surfaces());
  tracer.add_samples(buffer, 0, 1);
  EXPECT_TRUE(tracer.variances().empty());
  tracer.add_samples(buffer, 1, 7);
  const std::vector<float> variances = tracer.variances();
  const Indirect indirect = tracer.indirect(buffer);
  int uneven = 0;
  each_hit(buffer, [&](std::size_t place) {
    const double p = indirect.sky[place];
    EXPECT_NEAR(variances[place], p * (1 - p) / 7, 1e-7);
    uneven += p > 0 && p < 1;
  });
  EXPECT_GT(uneven, 50);
}

}  // namespace
}  // namespace isolux
