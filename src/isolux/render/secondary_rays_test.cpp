#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "isolux/base/error.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/render/explanation.h"
#include "isolux/render/pictures.h"
#include "isolux/render/ray_caster.h"
#include "isolux/render/relight.h"
#include "isolux/render/shadows.h"
#include "isolux/render/test_scenes.h"
#include "isolux/scene/document.h"
#include "isolux/volume/phantom.h"

// Shadows, mirrors and translucent surfaces against closed forms.

namespace isolux {
namespace {

using nlohmann::json;
using std::numbers::pi;

constexpr int kSize = kTestSize;

// f = z on a grid of 1 mm about the origin: the isosurface at v is the plane z = -v, outside up.
Volume slope(int size) {
  Volume v = sphere_phantom(size);
  std::vector<float> values;
  const double half = (size - 1) / 2.0;
  v.world_from_index = {Mat3{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {-half, -half, -half}};
  for (int k = 0; k < size; ++k) {
    values.insert(values.end(), static_cast<std::size_t>(size) * static_cast<std::size_t>(size),
                  static_cast<float>(half - k));
  }
  v.voxels = Voxels<float>(std::move(values));
  return v;
}

struct Lit {
  Scene scene;
  SurfaceBuffer buffer;
  Shadows shadows;
  Radiance radiance;
};

Lit lit(const Scene& scene) {
  const RayCaster caster(scene);
  SurfaceBuffer buffer = caster.cast(*scene.camera);
  Shadows shadows;
  cast_shadows(scene, caster.surfaces(), buffer, shadows);
  Radiance radiance = light(scene, buffer, shadows);
  return {scene, std::move(buffer), std::move(shadows), std::move(radiance)};
}

// Calls body(place, x, y, sample, position) for every pixel that shows a surface.
template <typename Body>
int each_hit(const Lit& picture, const Body& body) {
  int hits = 0;
  for (int y = 0; y < picture.buffer.height(); ++y) {
    for (int x = 0; x < picture.buffer.width(); ++x) {
      const std::size_t place = picture.buffer.at(x, y);
      const SurfaceSample sample = picture.buffer.sample(place);
      if (!sample.is_hit()) continue;
      ++hits;
      body(place, x, y, sample, picture.scene.camera->ray(x, y).at(sample.depth_mm));
    }
  }
  return hits;
}

Vec3 to_light(const Light& light, Vec3 from) {
  return light.kind == Light::Kind::kPoint ? normalize(light.place - from) : normalize(light.place);
}

json lamps_around(double distance) {
  std::mt19937 random(5);
  std::normal_distribution<double> any;
  json lights = json::array();
  for (int n = 0; n < 24; ++n) {
    const Vec3 d = normalize(Vec3{any(random), any(random), any(random)});
    if (n % 2 == 0) {
      lights.push_back({{"kind", "directional"}, {"to", {d.x, d.y, d.z}}});
    } else {
      lights.push_back(
          {{"kind", "point"}, {"at", {distance * d.x, distance * d.y, distance * d.z}}});
    }
  }
  return lights;
}

// Counts lit points that lie in shadow all the same.
double share_in_shadow(const Scene& scene) {
  const Lit picture = lit(scene);
  int lit_points = 0, dark = 0;
  const int hits = each_hit(
      picture, [&](std::size_t place, int, int, const SurfaceSample& sample, Vec3 position) {
        for (std::size_t l = 0; l < scene.lights.size(); ++l) {
          if (dot(sample.normal(), to_light(scene.lights[l], position)) <= 0) continue;
          ++lit_points;
          dark += picture.shadows.pixels[l][place] < 1;
        }
      });
  EXPECT_GT(hits, 300);
  EXPECT_GT(lit_points, 5 * hits);
  return static_cast<double>(dark) / lit_points;
}

TEST(Shadows, a_convex_body_never_lies_in_its_own_shadow) {
  // Neither specks where a shadow ray meets its own start, nor black patches where the shading
  // normal faces a lamp that the facets turn away from: fine voxels, coarse ones, and triangles.
  const json settings = {{"shadows", "on"},
                         {"surface", {{{"iso", 0.5}}}},
                         {"camera", {{"projection", "orthographic"}, {"height", 36}}},
                         {"light", lamps_around(60)}};
  for (const int size : {65, 33, 17}) {
    EXPECT_EQ(share_in_shadow(scene_of({volume(sphere_phantom(size))}, settings)), 0) << size;
  }
  json of_mesh = settings;
  of_mesh.erase("surface");
  // At a corner the shading normal of triangles of edge a may lean by a / (sqrt(3) R), where the
  // way through the body is 2 a / sqrt(3) long: a little more than the edge that is let pass.
  EXPECT_LT(share_in_shadow(scene_of({mesh(extract_isosurface(sphere_phantom(33), 0.5))}, of_mesh)),
            1e-3);
  json raster = settings;
  raster["visibility"] = "raster";
  EXPECT_LT(share_in_shadow(scene_of({volume(sphere_phantom(33))}, raster)), 1e-3);
}

TEST(Shadows, a_sphere_darkens_the_floor_where_its_cone_meets_it) {
  // A floor point lies in shadow if the way to the lamp passes the centre nearer than the radius,
  // 16; the voxels' sphere is off by no more than 1 mm^2 / (8 * 16) < 0.01, as that of a chord.
  const json settings = {{"shadows", "on"},
                         {"surface", {{{"iso", 0.5}}}},
                         {"camera", {{"eye", {150, -200, 160}}, {"target", {0, 0, -20}}}},
                         {"light",
                          {{{"kind", "point"}, {"at", {30, -20, 60}}},
                           {{"kind", "directional"}, {"to", {-1, 1, 2}}}}}};
  const Scene scene = scene_of({volume(sphere_phantom()), mesh(square(-30, 80, false))}, settings);
  const Lit picture = lit(scene);
  int dark = 0, bright = 0;
  each_hit(picture, [&](std::size_t place, int, int, const SurfaceSample& sample, Vec3 position) {
    if (sample.surface != 1) return;
    for (std::size_t l = 0; l < 2; ++l) {
      const Vec3 way = to_light(scene.lights[l], position);
      const double passes = length(cross(position, way));
      const float share = picture.shadows.pixels[l][place];
      if (passes < 15.99) {
        ++dark;
        EXPECT_EQ(share, 0);
      }
      if (passes > 16.01) {
        ++bright;
        EXPECT_EQ(share, 1);
      }
    }
  });
  EXPECT_GT(dark, 100);
  EXPECT_GT(bright, 300);
}

TEST(Shadows, no_light_leaks_through_bone_one_voxel_thick) {
  // Sheets of single voxels, along an axis and along two diagonals, between a lamp and a floor. The
  // lowest value in the middle of the sheets is 444 (where three voxels 1000 meet: 3 * 4/27).
  constexpr int kVoxels = 41;
  for (const auto& slant : {std::array{0, 0, 1}, {1, 0, 1}, {1, 1, 1}}) {
    Volume bone = slope(kVoxels);
    std::vector<float> values;
    for (int k = 0; k < kVoxels; ++k) {
      for (int j = 0; j < kVoxels; ++j) {
        for (int i = 0; i < kVoxels; ++i) {
          const int at = slant[0] * (i - 20) + slant[1] * (j - 20) + slant[2] * (k - 20);
          values.push_back(at == 0 ? 1000 : 0);
        }
      }
    }
    bone.voxels = Voxels<float>(std::move(values));
    const Scene scene = scene_of({volume(std::move(bone)), mesh(square(-25, 30, false))},
                                 {{"shadows", "on"},
                                  {"surface", {{{"iso", 300}}}},
                                  {"camera", {{"eye", {60, -70, -5}}, {"target", {0, 0, -25}}}},
                                  {"light", {{{"kind", "point"}, {"at", {2, 1, 60}}}}}});
    const Lit picture = lit(scene);
    int behind = 0;
    each_hit(picture, [&](std::size_t place, int, int, const SurfaceSample& sample, Vec3 p) {
      if (sample.surface != 1) return;
      // Where the way to the lamp passes the middle of the sheet.
      const Vec3 normal{double(slant[0]), double(slant[1]), double(slant[2])};
      const Vec3 way = scene.lights[0].place - p;
      const Vec3 through = p - dot(normal, p) / dot(normal, way) * way;
      if (std::max({std::fabs(through.x), std::fabs(through.y), std::fabs(through.z)}) > 18) return;
      ++behind;
      EXPECT_EQ(picture.shadows.pixels[0][place], 0);
    });
    EXPECT_GT(behind, 40);
  }
}

// V by its definition, in doubles, for an opaque isosurface.
float plain_share(const Scene& scene, const std::vector<IsoSurface>& surfaces, const Ray& eye_ray,
                  const SurfaceSample& sample, const Light& light) {
  const IsoSurface& own = surfaces[static_cast<std::size_t>(sample.surface)];
  const double t = own.first_hit(eye_ray)->t;
  const Vec3 start = eye_ray.at(own.t_before(eye_ray, t));
  const bool is_point = light.kind == Light::Kind::kPoint;
  const Vec3 l = to_light(light, start);
  const double far =
      is_point ? length(light.place - start) : std::numeric_limits<double>::infinity();
  const auto true_normal = own.true_normal(eye_ray.at(t));
  const bool faces_away =
      true_normal && dot(*true_normal, l) * dot(*true_normal, eye_ray.direction) > 0;
  for (const IsoSurface& surface : surfaces) {
    const double diagonal = length(scene.surfaces[0].volume->world_from_index.vector({1, 1, 1}));
    const double begin = &surface == &own && faces_away ? diagonal : 0;
    if (begin < far && surface.first_hit({start + begin * l, l}, far - begin)) return 0;
  }
  return 1;
}

TEST(Shadows, lanes_agree_with_the_plain_definition_on_a_head) {
  const Scene scene =
      scene_of({volume(head_phantom(64))}, {{"size", {96, 96}},
                                            {"shadows", "on"},
                                            {"surface", {{{"iso", 300}}, {{"iso", 600}}}},
                                            {"light", lamps_around(200)}});
  const auto bricks = std::make_shared<const BrickGrid>(*scene.surfaces[0].volume);
  std::vector<IsoSurface> plain;
  for (const SurfaceItem& item : scene.surfaces) plain.emplace_back(item.volume, bricks, item.iso);
  const Lit picture = lit(scene);
  int points = 0, dark = 0, differ = 0;
  each_hit(picture, [&](std::size_t place, int x, int y, const SurfaceSample& sample, Vec3 p) {
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
      const Light& lamp = scene.lights[l];
      if (dot(sample.normal(), to_light(lamp, p)) < 1e-4) continue;
      const float share = picture.shadows.pixels[l][place];
      ++points;
      dark += share == 0;
      differ += share != plain_share(scene, plain, scene.camera->ray(x, y), sample, lamp);
    }
  });
  EXPECT_GT(dark, points / 50);
  EXPECT_GT(points, 5000);
  // Starts differ by the error of a hit, so that a ray that grazes may go either way.
  EXPECT_LE(differ, points / 1000);
}

TEST(Shadows, translucent_surfaces_dim_by_one_minus_opacity_at_every_crossing) {
  // Through two spheres about one centre a ray crosses 0, 2 or 4 surfaces.
  const Scene scene =
      scene_of({volume(sphere_phantom()), mesh(square(-40, 80, false))},
               {{"shadows", "on"},
                {"surface", {{{"iso", 0.5}, {"opacity", 0.3}}, {{"iso", 0.75}, {"opacity", 0.6}}}},
                {"camera", {{"eye", {150, -200, 160}}, {"target", {0, 0, -40}}, {"fov", 50}}},
                {"light", {{{"kind", "directional"}, {"to", {0, 0, 1}}}}}});
  const Lit picture = lit(scene);
  int through[3] = {};
  each_hit(picture, [&](std::size_t place, int, int, const SurfaceSample& sample, Vec3 p) {
    if (sample.surface != 2) return;
    const double passes = std::hypot(p.x, p.y);
    if (std::fabs(passes - 16) < 0.02 || std::fabs(passes - 8) < 0.05) return;
    const int kind = passes > 16 ? 0 : passes > 8 ? 1 : 2;
    ++through[kind];
    const double expected[] = {1, 0.7 * 0.7, 0.7 * 0.7 * 0.4 * 0.4};
    EXPECT_NEAR(picture.shadows.pixels[0][place], expected[kind], 1e-6) << passes;
  });
  for (const int count : through) EXPECT_GT(count, 2);
}

TEST(Opacity, layers_add_up_nearest_first_whichever_is_named_first) {
  // Through both spheres: red, green, green, red; through the outer alone: red, red.
  const json red = {
      {"iso", 0.5}, {"ka", {1, 0, 0}}, {"kd", {0, 0, 0}}, {"ks", {0, 0, 0}}, {"opacity", 0.3}};
  const json green = {
      {"iso", 0.75}, {"ka", {0, 1, 0}}, {"kd", {0, 0, 0}}, {"ks", {0, 0, 0}}, {"opacity", 0.6}};
  for (const json& surfaces : {json{red, green}, json{green, red}}) {
    const Scene scene = scene_of({volume(sphere_phantom())},
                                 {{"surface", surfaces},
                                  {"ambient", {1, 1, 1}},
                                  {"background", {0, 0, 1}},
                                  {"camera", {{"projection", "orthographic"}, {"height", 36}}}});
    const Lit picture = lit(scene);
    const Layers layers = exr_layers(scene, picture.buffer, picture.radiance);
    int both = 0, one = 0;
    each_hit(picture, [&](std::size_t place, int x, int y, const SurfaceSample&, Vec3 p) {
      const double passes = std::hypot(p.x, p.z);
      const Rgb total = picture.radiance.total.at(place);
      const auto pixel = static_cast<std::size_t>(kSize * y + x);
      if (passes < 7.9) {
        ++both;
        EXPECT_NEAR(total.r, 0.3 + 0.7 * 0.4 * 0.4 * 0.3, 1e-6);
        EXPECT_NEAR(total.g, 0.7 * (0.6 + 0.4 * 0.6), 1e-6);
        EXPECT_NEAR(total.b, 0.7 * 0.4 * 0.4 * 0.7, 1e-6);
        EXPECT_NEAR(layers.find("A")->values[pixel], 1 - 0.7 * 0.4 * 0.4 * 0.7, 1e-6);
        EXPECT_NEAR(layers.find("ambient.G")->values[pixel], total.g, 1e-6);
      } else if (passes > 8.1 && passes < 15.9) {
        ++one;
        EXPECT_NEAR(total.r, 0.3 + 0.7 * 0.3, 1e-6);
        EXPECT_EQ(total.g, 0);
        EXPECT_NEAR(total.b, 0.7 * 0.7, 1e-6);
      }
    });
    EXPECT_GT(both, 200);
    EXPECT_GT(one, 500);
  }
}

TEST(Opacity, an_explanation_lists_the_layers_and_their_terms_add_up) {
  const Scene scene = scene_of(
      {volume(sphere_phantom())},
      {{"shadows", "on"},
       {"surface", {{{"iso", 0.5}, {"opacity", 0.3}}, {{"iso", 0.75}, {"kr", {0.2, 0.3, 0.4}}}}},
       {"background", {0.1, 0.2, 0.3}},
       {"light", {{{"kind", "point"}, {"at", {30, -70, 30}}}}}});
  const Lit picture = lit(scene);
  each_hit(picture, [&](std::size_t place, int x, int y, const SurfaceSample&, Vec3) {
    if ((x + y) % 5 != 0) return;
    const Explanation e = explain(scene, x, y);
    EXPECT_EQ(e.radiance, picture.radiance.total.at(place));
    Rgb sum = e.mirror + e.background;
    for (const ExplainedLayer& layer : e.layers) sum = sum + layer.weight * layer.terms.total;
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(sum[c], e.total[c], 1e-12);
      EXPECT_NEAR(sum[c], e.radiance[c], 2e-5);
    }
    ASSERT_EQ(e.layers.size(), 2u);  // in and out of the outer, or the outer and the opaque one
    EXPECT_NEAR(e.layers[0].weight, 0.3, 1e-6);
    EXPECT_NEAR(e.layers[1].weight, e.layers[1].surface == 1 ? 0.7 : 0.21, 1e-6);
  });
}

// The point of the plane z = height that a ray meets.
Vec3 on_plane(const Ray& ray, double height) {
  return ray.at((height - ray.origin.z) / ray.direction.z);
}

// What a ray sees of square(z, half, ...) with ambient light 1: its colour there.
Rgb color_of_square(Vec3 at, double half) {
  return {(at.x / half + 1) / 2, (at.y / half + 1) / 2, 0.25};
}

constexpr double kHigh = 90, kHalf = 300;

TEST(Mirror, a_flat_mirror_shows_what_the_mirrored_eye_ray_meets) {
  // Under a coloured ceiling; the mirror once an isosurface, once a mesh.
  const json black = {
      {"ka", {0, 0, 0}}, {"kd", {0, 0, 0}}, {"ks", {0, 0, 0}}, {"kr", {1, 0.5, 0.25}}};
  for (const bool is_mesh : {false, true}) {
    json surface = black;
    if (is_mesh) {
      surface["input"] = 1;
    } else {
      surface["iso"] = 0;
    }
    const SceneInput plane = is_mesh ? mesh(square(0, 15, false)) : volume(slope(31));
    const Scene scene = scene_of({plane, mesh(square(kHigh, kHalf, true))},
                                 {{"surface", {surface}},
                                  {"ambient", {1, 1, 1}},
                                  {"camera", {{"eye", {20, -60, 40}}, {"target", {0, 0, 0}}}}});
    const Lit picture = lit(scene);
    int mirrored = 0;
    each_hit(picture, [&](std::size_t place, int x, int y, const SurfaceSample& sample, Vec3 p) {
      if (sample.surface != 0) return;
      ++mirrored;
      const Vec3 d = scene.camera->ray(x, y).direction;
      const Rgb seen = color_of_square(on_plane({p, {d.x, d.y, -d.z}}, kHigh), kHalf);
      const Rgb total = picture.radiance.total.at(place);
      EXPECT_NEAR(total.r, seen.r, 1e-5);
      EXPECT_NEAR(total.g, 0.5 * seen.g, 1e-5);
      EXPECT_NEAR(total.b, 0.25 * seen.b, 1e-5);
      EXPECT_EQ(picture.radiance.mirror.at(place), total);
    });
    EXPECT_GT(mirrored, 500);
  }
}

TEST(Mirror, a_mirror_sphere_shows_what_analytic_reflection_says) {
  // Of a sphere of radius R the normal at p is p / R. The voxels' normals (steps of h = 0.5 mm) are
  // off by some (h / R)^2, and at a distance of some 200 mm on a ceiling of 600 that is 1e-3.
  const Scene scene =
      scene_of({volume(sphere_phantom(129)), mesh(square(kHigh, kHalf, true))},
               {{"surface",
                 {{{"iso", 0.5},
                   {"ka", {0, 0, 0}},
                   {"kd", {0, 0, 0}},
                   {"ks", {0, 0, 0}},
                   {"kr", {1, 1, 1}}}}},
                {"ambient", {1, 1, 1}},
                {"background", {0, 0, 1}},
                {"camera", {{"eye", {0, -60, 70}}, {"target", {0, 0, 4}}, {"fov", 20}}}});
  const Lit picture = lit(scene);
  int ceiling = 0, background = 0;
  each_hit(picture, [&](std::size_t place, int x, int y, const SurfaceSample& sample, Vec3 p) {
    if (sample.surface != 0) return;
    const Vec3 d = scene.camera->ray(x, y).direction, n = normalize(p);
    const Vec3 r = d - 2 * dot(d, n) * n;
    const Rgb total = picture.radiance.total.at(place);
    const Vec3 met = on_plane({p, r}, kHigh);
    const double widest = std::max(std::fabs(met.x), std::fabs(met.y));
    if (r.z > 0.1 && widest < 280) {
      ++ceiling;
      const Rgb seen = color_of_square(met, kHalf);
      EXPECT_NEAR(total.r, seen.r, 4e-3);
      EXPECT_NEAR(total.g, seen.g, 4e-3);
    } else if (r.z < 0 || widest > 320) {
      ++background;
      EXPECT_EQ(total, (Rgb{0, 0, 1}));
    }
  });
  EXPECT_GT(ceiling, 300);
  EXPECT_GT(background, 100);
}

TEST(Mirror, between_two_mirrors_reflections_add_up_to_the_mirror_depth) {
  // Each mirror shines a = 0.2 by itself and sends half on: I = a (1 + 1/2 + ... + 1/2^depth).
  for (const int depth : {0, 1, 4, 9}) {
    const json half = {
        {"ka", {0.2, 0.2, 0.2}}, {"kd", {0, 0, 0}}, {"ks", {0, 0, 0}}, {"kr", {0.5, 0.5, 0.5}}};
    json lower = half, upper = half;
    lower["input"] = 1;
    upper["input"] = 2;
    Mesh below = square(0, 200, false), above = square(50, 200, true);
    below.colors.clear();
    above.colors.clear();
    const Scene scene =
        scene_of({mesh(below), mesh(above)},
                 {{"surface", {lower, upper}},
                  {"ambient", {1, 1, 1}},
                  {"mirror-depth", depth},
                  {"camera", {{"eye", {0, 0, 20}}, {"target", {0, 0, 0}}, {"up", {0, 1, 0}}}}});
    const Lit picture = lit(scene);
    const double expected = 0.2 * (2 - std::pow(0.5, depth));
    const int hits = each_hit(picture, [&](std::size_t place, int, int, const auto&, Vec3) {
      EXPECT_NEAR(picture.radiance.total.at(place).g, expected, 1e-6) << depth;
    });
    EXPECT_EQ(hits, kSize * kSize);
  }
}

TEST(Mirror, translucent_mirrors_that_multiply_without_end_are_refused) {
  // Each meeting of a ray with either square makes two of it, each with half the weight, so a pixel
  // has a million before they count as nothing.
  const json half = {{"kr", {1, 1, 1}}, {"opacity", 0.5}};
  json lower = half, upper = half;
  lower["input"] = 1;
  upper["input"] = 2;
  json settings = {{"surface", {lower, upper}},
                   {"mirror-depth", 64},
                   {"camera", {{"eye", {0, 0, 20}}, {"target", {0, 0, 0}}, {"up", {0, 1, 0}}}}};
  const std::vector<SceneInput> inputs = {mesh(square(0, 200, false)), mesh(square(50, 200, true)),
                                          mesh(square(-50, 200, true)),
                                          mesh(square(90, 200, true))};
  settings["surface"].push_back({{"input", 3}, {"kr", {1, 1, 1}}});
  settings["surface"].push_back({{"input", 4}, {"kr", {1, 1, 1}}});
  const Scene endless = scene_of(inputs, settings);
  EXPECT_THROW(RayCaster(endless).cast(*endless.camera), WorkError);
  settings["mirror-depth"] = 3;
  const Scene bounded = scene_of(inputs, settings);
  EXPECT_NO_THROW(RayCaster(bounded).cast(*bounded.camera));
}

TEST(Mirror, a_faultless_mirror_shows_the_lamp_where_phi_is_0_and_nowhere_else) {
  // (cos phi)^n > 0.01 with n = 1e6 asks for phi < sqrt(2 ln(100) / n) = 0.00304.
  const Scene scene = scene_of({volume(sphere_phantom())},
                               {{"size", {200, 200}},
                                {"surface",
                                 {{{"iso", 0.5},
                                   {"kd", {0, 0, 0}},
                                   {"ks", {1, 1, 1}},
                                   {"kr", {1, 1, 1}},
                                   {"shininess", 1e6}}}},
                                {"camera", {{"projection", "orthographic"}, {"height", 2}}},
                                {"light", {{{"kind", "directional"}, {"to", {0, -1, 0}}}}}});
  const Lit picture = lit(scene);
  int shining = 0;
  each_hit(picture, [&](std::size_t place, int, int, const SurfaceSample& sample, Vec3) {
    if (picture.radiance.specular.at(place).g < 0.01) return;
    ++shining;
    // The lamp is at the eye, so phi is twice the angle between n and e.
    EXPECT_GT(dot(sample.normal(), Vec3{0, -1, 0}), std::cos(0.00305 / 2));
  });
  EXPECT_GT(shining, 0);
  EXPECT_LT(shining, 400);
}

}  // namespace
}  // namespace isolux
