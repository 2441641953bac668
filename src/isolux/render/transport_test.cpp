#include "isolux/render/transport.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "isolux/base/parallel.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/render/cosine_direction.h"
#include "isolux/render/gathered_light.h"
#include "isolux/render/light_spread.h"
#include "isolux/render/path_tracer.h"
#include "isolux/render/ray_caster.h"
#include "isolux/render/site_weights.h"
#include "isolux/render/test_scenes.h"
#include "isolux/volume/analytic_volume.h"
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
    transport.gather_sky(buffer, indirect);
  }
};

json settings_of(const json& surface, const std::vector<json>& lamps, int bounces) {
  return {{"surface", json::array({surface})},
          {"light", lamps},
          {"shadows", "on"},
          {"indirect", "path"},
          {"bounces", bounces}};
}

const json kLampA = {{"kind", "point"}, {"at", {-90, -200, 60}}, {"color", {1, 0.5, 0.2}}};
const json kLampB = {{"kind", "directional"}, {"to", {1, -0.2, 0.3}}};
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
    transport.gather_sky(pieces.buffer, pieces.indirect);
  });
  each_hit(whole->buffer, [&](std::size_t place) {
    EXPECT_EQ(whole->indirect.pixels.at(place), pieces.indirect.pixels.at(place));
    EXPECT_EQ(whole->indirect.sky[place], pieces.indirect.sky[place]);
  });
}

TEST(Transport, what_was_seen_before_changes_no_picture) {
  const Scene scene = head_scene({kLampA, kLampB});
  const Lit fresh(scene);
  Lit after(scene, {.links = 8});
  Transport transport(scene, after.caster.surfaces());
  json settings = settings_of({{"iso", 300}}, {kLampA}, 2);
  settings["camera"] = {{"view", "left"}};
  const Scene other = scene_of({volume(head_phantom(48))}, settings);
  const SurfaceBuffer aside = after.caster.cast(*other.camera);
  const auto draw = [&](const Scene& seen, const SurfaceBuffer& buffer) {
    transport.see(seen, buffer);
    EXPECT_TRUE(transport.refine(scene.bounces));
    transport.light(scene);
    transport.gather(buffer, after.indirect);
    transport.gather_sky(buffer, after.indirect);
  };
  draw(other, aside);
  draw(scene, after.buffer);
  each_hit(fresh.buffer, [&](std::size_t place) {
    EXPECT_EQ(fresh.indirect.pixels.at(place), after.indirect.pixels.at(place));
    EXPECT_EQ(fresh.indirect.sky[place], after.indirect.sky[place]);
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

TEST(Transport, nothing_comes_through_a_closed_shell) {
  // The eye is within the shell, the lamps are not. With face normals there is nothing to see, to
  // the last bit. Normals smoother than the surface face a lamp here and there where it does not,
  // by a hair, and the contract then lets light in (the shadow terminator): less than 1 in 1000.
  Mesh facets = extract_isosurface(sphere_phantom(33), 0.5);
  facets.normals.clear();
  const json albedo = {0.7, 0.7, 0.7};
  const std::tuple<SceneInput, json, double> shells[] = {
      {mesh(std::move(facets)), {{"input", 1}, {"kd", albedo}}, 0},
      {volume(sphere_phantom()), {{"iso", 0.5}, {"kd", albedo}}, 0.001}};
  for (const auto& [input, surface, most] : shells) {
    json settings = settings_of(surface, {kLampA, kLampB}, 3);
    settings["camera"] = {{"eye", {0, 0, 0}}, {"target", {1, 2, 1}}, {"fov", 120}};
    const Lit lit(scene_of({input}, settings));
    const int hits = each_hit(lit.buffer, [&](std::size_t place) {
      EXPECT_LE(lit.indirect.pixels.at(place).r, most);
      EXPECT_EQ(lit.indirect.sky[place], 0);
    });
    EXPECT_EQ(hits, kTestSize * kTestSize);
  }
}

TEST(Transport, nothing_comes_through_a_sheet_of_one_voxel) {
  // A sheet from z = 7 to 9 mm over a floor at -25, as wide as the volume of 2 mm voxels. Under a
  // lamp straight above, what lies between is in the sheet's shadow and sees nothing that is not.
  const Volume sheet_and_floor = sample_on_cube<float>(
      33, 32, [](Vec3 p_mm) { return p_mm.z < -25 || p_mm.z == 8 ? 1.0 : 0.0; });
  for (const double down : {-1.0, 1.0}) {
    json settings = settings_of({{"iso", 0.5}}, {{{"kind", "directional"}, {"to", {0, 0, 1}}}}, 3);
    settings["camera"] = {{"eye", {0, 0, -9}}, {"target", {8, 4, -9 + 16 * down}}, {"fov", 70}};
    const Lit lit(scene_of({volume(sheet_and_floor)}, settings));
    const int hits = each_hit(
        lit.buffer, [&](std::size_t place) { EXPECT_EQ(lit.indirect.pixels.at(place), Rgb{}); });
    EXPECT_GT(hits, kTestSize * kTestSize / 2);
  }
}

// Two squares that face each other: half width 10 at z = 0 and half width 6 at z = 12. Without
// shadows a lamp straight below lights the small one's face all over and no other that sees one,
// and a lamp straight above the large one's. An orthographic camera between them counts the same
// area for every pixel, so that the sum over its pixels is what light arrives.
template <typename Method>
double arriving_at(bool at_small, const Method& method) {
  json settings = settings_of({{"input", 1}},
                              {{{"kind", "directional"}, {"to", {0, 0, at_small ? 1 : -1}}}}, 1);
  settings["shadows"] = "off";
  settings["spp"] = 256;
  settings["camera"] = {{"eye", {0, 0, 6}},
                        {"target", {0, 0, at_small ? 12 : 0}},
                        {"up", {0, 1, 0}},
                        {"projection", "orthographic"},
                        {"height", 24}};
  const Scene scene = scene_of({mesh(square(0, 10, false)), mesh(square(12, 6, true))}, settings);
  double sum = 0;
  method(scene, [&](const SurfaceBuffer& buffer, const Indirect& indirect) {
    each_hit(buffer, [&](std::size_t place) { sum += indirect.pixels.at(place).b; });
  });
  return sum;
}

TEST(Transport, what_one_square_sends_to_another_it_would_get_from_it) {
  // Squares have the same albedo all over in blue.
  const auto by_transport = [](const Scene& scene, const auto& use) {
    const Lit lit(scene);
    use(lit.buffer, lit.indirect);
  };
  const auto by_paths = [](const Scene& scene, const auto& use) {
    const RayCaster caster(scene);
    const SurfaceBuffer buffer = caster.cast(*scene.camera);
    PathTracer tracer(scene, caster.surfaces());
    tracer.run(buffer);
    use(buffer, tracer.indirect(buffer));
  };
  const double up = arriving_at(true, by_paths), down = arriving_at(false, by_paths);
  EXPECT_GT(up, 10);
  EXPECT_NEAR(up, down, 0.02 * up);
  EXPECT_NEAR(arriving_at(true, by_transport), up, 0.02 * up);
  EXPECT_NEAR(arriving_at(false, by_transport), up, 0.02 * up);
}

TEST(Transport, a_sheet_close_under_another_does_not_show_the_dark_between_them) {
  // A lamp's square under a ceiling, as in the Cornell box, nearer than half a block of samples
  // (the root of its area / 160,000: 0.05). Both see the floor, but what of the ceiling is behind
  // the square sees nothing.
  Mesh ceiling = square(12, 10, true);
  const Mesh lamp = square(11.99, 4, true);
  for (const auto& [a, b, c] : lamp.triangles) ceiling.triangles.push_back({a + 4, b + 4, c + 4});
  ceiling.positions.insert(ceiling.positions.end(), lamp.positions.begin(), lamp.positions.end());
  ceiling.colors.insert(ceiling.colors.end(), lamp.colors.begin(), lamp.colors.end());
  ceiling.parts = {{0, 4, 0}};
  json settings = settings_of({{"input", 1}}, {{{"kind", "directional"}, {"to", {0, 0, 1}}}}, 1);
  settings["shadows"] = "off";
  settings["camera"] = {{"eye", {0, 0, 6}},
                        {"target", {0, 0, 12}},
                        {"up", {0, 1, 0}},
                        {"projection", "orthographic"},
                        {"height", 7}};
  const Lit lit(scene_of({mesh(square(0, 10, false)), mesh(std::move(ceiling))}, settings));
  // In the middle, the floor's form factor of 0.464 (a square of 20 seen from 12) times its albedo
  // in blue, 1/2 * 1/4; at the square's corner 0.421.
  const int hits = each_hit(lit.buffer, [&](std::size_t place) {
    EXPECT_GT(lit.indirect.pixels.at(place).b, 0.41 / 8);
    EXPECT_LT(lit.indirect.pixels.at(place).b, 0.475 / 8);
  });
  EXPECT_EQ(hits, kTestSize * kTestSize);
}

TEST(Transport, turned_towards_the_light_a_point_receives_more_and_under_even_light_the_same) {
  // Links of a sample whose normal is z: half of them go sideways along +x, half along -x.
  SampleLinks row;
  for (std::uint32_t n = 0; n < 64; ++n) {
    const auto tilt = static_cast<std::int16_t>((n % 2 ? -0.5 : 0.5) / LinkTilt::kStep);
    row.links.push_back({n % 2, tilt, 0});
    row.all_tilt.add(row.links.back().tilt());
    ++row.rays;
  }
  const float even[2] = {1, 1}, uneven[2] = {1, 0};
  const Vec3 normal{0, 0, 1};
  const Vec3 x = TangentFrame(normal).across;
  const auto gathered = [&](const float* sent) {
    SlopedLight light;
    gather_sloped(row, {1, sent, {}}, normal, &light);
    return light;
  };
  const auto along_x = [&](const SlopedLight& light) {
    return x.x * light.slope[0] + x.y * light.slope[1] + x.z * light.slope[2];
  };
  EXPECT_EQ(gathered(even).mean, 1);
  EXPECT_NEAR(along_x(gathered(even)), 0, 1e-6);
  EXPECT_EQ(gathered(uneven).mean, 0.5f);
  // Half of the light, from directions that lean by 1/2: 5/4 * 1/2 * 1/2.
  EXPECT_NEAR(along_x(gathered(uneven)), 5.0 / 16, 1e-4);
}

TEST(Transport, close_and_further_light_are_all_light) {
  // Four links of eight rays, the first and the third of them to what is close, and two to the sky.
  SampleLinks row{{{0, 100, -50}, {1, 300, 20}, {2, -700, 5}, {0, 9, 800}}, {0, 2}, 8, 2, {}, {}};
  row.sky_tilt = {-40, 60};
  row.all_tilt = row.sky_tilt;
  for (const Link& link : row.links) row.all_tilt.add(link.tilt());
  const float numbers[] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  const SentLight sent{3, numbers, {0.5, 0.5, 0.5}};
  const Vec3 normal = normalize(Vec3{1, 2, 3});
  SlopedLight all[3], further[3];
  gather_sloped(row, sent, normal, all);
  gather_further(row, sent, normal, further);
  // Without links 0 and 2, which bring (1 + 7) / 8, (2 + 8) / 8 and (3 + 9) / 8.
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(all[c].mean - further[c].mean, 1 + 0.25 * static_cast<double>(c), 1e-6);
  }
  // Where all light is 1, what is close brings its share, and the rest 1 less that, at any normal.
  const float ones[] = {1, 1, 1};
  SampleLinks closed = row;
  closed.links.insert(closed.links.end(), {{1, 0, 0}, {1, 0, 0}});
  SlopedLight rest;
  gather_further(closed, {1, ones, {1, 1, 1}}, normal, &rest);
  const SlopedLight close = close_share(closed, normal);
  EXPECT_EQ(close.mean, 2.0f / 8);
  EXPECT_NEAR(rest.mean + close.mean, 1, 1e-6);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(rest.slope[axis] + close.slope[axis], 0, 1e-6);
  }
}

TEST(Transport, lanes_blend_as_plain_code_does) {
  for (const std::size_t channels : {1u, 3u}) {
    std::vector<SlopedLight> lights(3 * channels);
    for (std::size_t n = 0; n < lights.size(); ++n) {
      const auto value = static_cast<float>(n);
      lights[n].mean = 0.1f * value;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lights[n].slope[axis] = std::sin(value + static_cast<float>(axis));
      }
    }
    std::vector<BlendShare> shares;
    for (std::uint32_t n : {2u, 0u, 1u}) {
      shares.push_back({n, {}});
      for (std::size_t p = 0; p < BlendShare::kPixels; ++p) {
        shares.back().weight[p] = static_cast<std::uint16_t>(p * (n + 1) * 997);
      }
    }
    float normals[3][BlendShare::kPixels], plain[3][BlendShare::kPixels],
        lanes[3][BlendShare::kPixels];
    for (int axis = 0; axis < 3; ++axis) {
      for (int p = 0; p < BlendShare::kPixels; ++p) {
        // The first pixel has no weight; its normal may be anything.
        normals[axis][p] = p == 0 ? NAN : std::cos(static_cast<float>(p + 5 * axis));
      }
    }
    float* const to_lanes[] = {lanes[0], lanes[1], lanes[2]};
    float* const to_plain[] = {plain[0], plain[1], plain[2]};
    blend(shares, lights.data(), {normals[0], normals[1], normals[2]}, {to_lanes, channels});
    blend_plainly(shares, lights.data(), {normals[0], normals[1], normals[2]},
                  {to_plain, channels});
    for (std::size_t c = 0; c < channels; ++c) {
      for (int p = 0; p < BlendShare::kPixels; ++p) EXPECT_NEAR(lanes[c][p], plain[c][p], 1e-5);
    }
  }
}

TEST(Transport, lanes_sum_links_as_plain_code_does) {
  // Of values n / 64 and tilts below 2^6 all sums over up to 70 links are whole multiples of 1 / 64
  // below 2^24 / 64: exact in whatever order.
  std::vector<float> sent(3 * 50);
  for (std::size_t n = 0; n < sent.size(); ++n) sent[n] = static_cast<float>(n) / 64;
  std::vector<Link> links;
  for (std::uint32_t n = 0; n < 70; ++n) {
    links.push_back({n * 37 % 50, static_cast<std::int16_t>(n % 61 - 30),
                     static_cast<std::int16_t>(40 - n % 59)});
  }
  for (const std::size_t channels : {1u, 3u}) {
    for (const std::size_t count : {0u, 1u, 3u, 7u, 15u, 16u, 17u, 31u, 48u, 70u}) {
      const std::span<const Link> some(links.data(), count);
      const SentLight light{channels, sent.data(), {}};
      const LinkSums lanes = sum_links(some, light), plain = sum_links_plainly(some, light);
      EXPECT_EQ(lanes.light, plain.light) << count;
      EXPECT_EQ(lanes.across, plain.across) << count;
      EXPECT_EQ(lanes.along, plain.along) << count;
    }
  }
}

TEST(Transport, lanes_weigh_samples_as_plain_code_does) {
  const Scene scene = head_scene({kLampA});
  const RayCaster caster(scene);
  const SurfaceSamples samples(caster.surfaces(), 1);
  BlendPoints points;
  points.mask = 0x7FFF;  // the last is not asked for
  points.origin = as_double(samples.sites()[1000].in_blocks);
  std::vector<std::uint32_t> which;
  for (std::uint32_t n = 800; n < 1200; ++n) which.push_back(n);
  for (std::size_t n = 0; n < BlendPoints::kCount; ++n) {
    const SampleSite& site = samples.sites()[995 + n];
    const Vec3 at = as_double(site.in_blocks) - points.origin + Vec3{0.3, -0.2, 0.1};
    const Vec3 normal = normalize(as_double(site.normal) + Vec3{0.1, 0.2, 0});
    const Vec3f position = as_float(at), turned = as_float(normal);
    points.x[n] = position.x, points.y[n] = position.y, points.z[n] = position.z;
    points.normal_x[n] = points.across_x[n] = turned.x;
    points.normal_y[n] = points.across_y[n] = turned.y;
    points.normal_z[n] = points.across_z[n] = turned.z;
  }
  std::vector<SiteWeights> lanes, plain;
  weigh_sites(points, samples.sites().data(), which, lanes);
  weigh_sites_plainly(points, samples.sites().data(), which, plain);
  ASSERT_EQ(lanes.size(), plain.size());
  EXPECT_GT(lanes.size(), 15);
  for (std::size_t n = 0; n < lanes.size(); ++n) {
    EXPECT_EQ(lanes[n].which, plain[n].which);
    EXPECT_EQ(lanes[n].lanes & 0x8000, 0);
    for (std::size_t lane = 0; lane < 15; ++lane) {
      EXPECT_NEAR(lanes[n].weight[lane], plain[n].weight[lane], 1e-5);
    }
  }
}

TEST(Transport, lanes_spread_light_as_plain_code_does) {
  for (const char* projection : {"perspective", "orthographic"}) {
    json settings = settings_of({{"iso", 300}}, {kLampA}, 2);
    settings["camera"] = {
        {"eye", {20, -400, 90}}, {"target", {0, 0, 10}}, {"fov", 32}, {"projection", projection}};
    if (projection == std::string("orthographic")) {
      settings["camera"].erase("fov");
      settings["camera"]["height"] = 220;
    }
    const Scene scene = scene_of({volume(head_phantom(48))}, settings);
    const RayCaster caster(scene);
    const SurfaceBuffer buffer = caster.cast(*scene.camera);
    RayFan fan = scene.camera->fan();
    fan.origin.first = fan.origin.first - scene.camera->eye();
    const auto place = static_cast<std::size_t>(buffer.at(24, 24)) / 16 * 16;
    SlopedLight lights[2][3];
    LightSpread::Point points[2];
    SpreadBlock block{place, 24, 24, 2, {&points[0], &points[1]}, {lights[0], lights[1]}};
    for (int p = 0; p < 2; ++p) {
      const int x = 25 + 2 * p, y = 26;
      const SurfaceSample sample = buffer.sample(buffer.at(x, y));
      ASSERT_TRUE(sample.is_hit());
      const Vec3 position = scene.camera->ray(x, y).at(sample.depth_mm) - scene.camera->eye();
      points[p] = {sample.surface,     static_cast<float>(x),     static_cast<float>(y),
                   as_float(position), as_float(sample.normal()), 0.01f};
      for (std::size_t c = 0; c < 3; ++c) {
        const auto value = static_cast<float>(p + 1) + 0.3f * static_cast<float>(c);
        lights[p][c] = {value, {0.1f * value, 0.2f, -0.1f}};
      }
    }
    std::vector<float> lanes[3], plain[3];
    for (auto* of : {lanes, plain}) {
      for (int c = 0; c < 3; ++c) of[c].resize(buffer.pixels());
    }
    float* const to_lanes[] = {lanes[0].data(), lanes[1].data(), lanes[2].data()};
    float* const to_plain[] = {plain[0].data(), plain[1].data(), plain[2].data()};
    spread_light(block, buffer, fan, scene.camera->is_orthographic(), to_lanes);
    spread_light_plainly(block, buffer, fan, scene.camera->is_orthographic(), to_plain);
    for (int c = 0; c < 3; ++c) {
      for (std::size_t n = place; n < place + 16; ++n) {
        EXPECT_NEAR(lanes[c][n], plain[c][n], 1e-3);
        EXPECT_GT(lanes[c][n], 0.5);
      }
    }
  }
}

TEST(Transport, a_sketch_is_even_where_light_is_even_and_near_the_whole_elsewhere) {
  // Inside a cavity of albedo rho with a lamp in its middle E is rho + rho^2 all over.
  constexpr double kAlbedo = 0.7;
  for (const auto& [input, surface] : spheres(kAlbedo)) {
    json inside = settings_of(surface, {kPointInTheMiddle}, 2);
    inside["camera"] = {{"eye", {0, 0, 0}}, {"target", {1, 2, 1}}, {"fov", 90}};
    Lit lit(scene_of({input}, inside));
    lit.transport.see(lit.scene, lit.buffer, PixelBlend::Detail::kSketch);
    EXPECT_FALSE(lit.transport.refine(lit.scene.bounces));
    lit.light(lit.scene);
    constexpr double kExpected = kAlbedo + kAlbedo * kAlbedo;
    each_hit(lit.buffer, [&](std::size_t place) {
      EXPECT_NEAR(lit.indirect.pixels.at(place).g, kExpected, 0.02 * kExpected);
    });
  }
  // On a head by the same links, seen from so near that a block of pixels is about one of samples:
  // what changes within one is lost, and what is close, which pixels' own links tell alone.
  json settings = settings_of({{"iso", 300}}, {kLampA, kLampB}, 3);
  settings["camera"] = {{"eye", {20, -400, 90}}, {"target", {0, 0, 10}}, {"fov", 7}};
  Lit lit(scene_of({volume(head_phantom(48))}, settings));
  const Indirect whole = lit.indirect;
  lit.transport.see(lit.scene, lit.buffer, PixelBlend::Detail::kSketch);
  lit.light(lit.scene);
  double mean = 0, off = 0;
  each_hit(lit.buffer, [&](std::size_t place) {
    mean += whole.pixels.at(place).g;
    off += std::fabs(lit.indirect.pixels.at(place).g - whole.pixels.at(place).g);
  });
  EXPECT_LT(off, 0.2 * mean);
}

TEST(Transport, a_lamp_moved_by_little_changes_no_pixel_by_more) {
  // Within a sphere of albedo rho and radius R, what one bounce brings is the same all over: rho
  // times the mean of n . l over the wall. Of a lamp at distance a from the middle that mean is
  // 1 - a^2 / (6 R^2) and less than that by the fourth order: over steps of R / 64 up to a = R / 4
  // it falls by less than 2 a (R / 64) / (6 R^2) = 0.0013 a step.
  constexpr double kRadius = 16, kAlbedo = 0.7;
  for (const auto& [input, surface] : spheres(kAlbedo)) {
    json settings = settings_of(surface, {kPointInTheMiddle}, 1);
    settings["camera"] = {{"eye", {0, 0, 0}}, {"target", {1, 2, 1}}, {"fov", 90}};
    Lit lit(scene_of({input}, settings));
    for (int step = 1; step <= 16; ++step) {
      const Indirect before = lit.indirect;
      Scene moved = lit.scene;
      moved.lights[0].place = {0, step * kRadius / 64, 0};
      lit.light(moved);
      each_hit(lit.buffer, [&](std::size_t place) {
        EXPECT_NEAR(lit.indirect.pixels.at(place).g, before.pixels.at(place).g, 0.004 * kAlbedo);
      });
    }
  }
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
