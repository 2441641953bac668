#include "isolux/render/relight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "isolux/render/ray_caster.h"
#include "isolux/scene/document.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

constexpr int kWidth = 61, kHeight = 43;

Scene scene_of(const json& settings) {
  json document = empty_document();
  document["size"] = {kWidth, kHeight};
  document["surface"] = {{{"iso", 0.5}, {"shininess", 0}},
                         {{"iso", 0.3}, {"shininess", 1000}, {"ks", {1, 0.5, 0.2}}}};
  document["light"] = {
      {{"kind", "point"}, {"at", {-30, -60, 57}}, {"intensity", 3}},
      {{"kind", "point"}, {"at", {40, -30, 0}}, {"falloff", "inverse-square"}, {"reference", 50}},
      {{"kind", "directional"}, {"to", {1, -2, 0.5}}, {"color", {0.2, 1, 0.5}}}};
  document.update(settings);
  SceneDescription description = describe(document, "scene");
  description.inputs = {"phantom:sphere"};
  return resolve(description, {{std::make_shared<Volume>(sphere_phantom())}});
}

void expect_as_light_point(const Scene& scene) {
  const SurfaceBuffer buffer = RayCaster(scene).cast(*scene.camera);
  const Radiance radiance = light(scene, buffer);
  Rgb intensities;
  for (const Light& one : scene.lights) {
    const double nearer = one.inverse_square_reference_mm ? 4 : 1;  // 25 mm of 50 at the nearest
    intensities = intensities + nearer * one.intensity;
  }
  PointTerms terms;
  int hits = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const std::size_t place = buffer.at(x, y);
      const SurfaceSample sample = buffer.sample(place);
      if (!sample.is_hit()) {
        EXPECT_EQ(radiance.total.at(place), scene.background);
        continue;
      }
      ++hits;
      light_point(scene, sample.surface, sample.point, point_of(scene.camera->ray(x, y), sample),
                  {}, nullptr, terms);
      const Material& material = scene.surfaces[static_cast<std::size_t>(sample.surface)].material;
      for (int c = 0; c < 3; ++c) {
        const double most = 2e-6 * (3 + std::sqrt(material.shininess)) * intensities[c];
        EXPECT_NEAR(radiance.ambient.at(place)[c], terms.ambient[c], most);
        EXPECT_NEAR(radiance.diffuse.at(place)[c], terms.diffuse[c], most);
        EXPECT_NEAR(radiance.specular.at(place)[c], terms.specular[c], most);
        EXPECT_NEAR(radiance.total.at(place)[c], terms.total[c], 3 * most);
      }
    }
  }
  EXPECT_GT(hits, 200);
}

TEST(Relight, lanes_give_the_terms_of_light_point) {
  expect_as_light_point(scene_of(json::object()));
  expect_as_light_point(scene_of({{"camera", {{"view", "left"}, {"projection", "orthographic"}}}}));
  expect_as_light_point(
      scene_of({{"camera", {{"eye", {0, 0, 0}}, {"target", {1, 2, 3}}, {"fov", 100}}}}));
}

// Grey and coloured pixels, side by side in a block too, and blocks at the picture's edges.
TEST(Relight, each_byte_of_a_picture_is_the_display_of_its_own_channel) {
  const json grey_lamp = {{{"kind", "point"}, {"at", {-30, -60, 57}}}};
  const json coloured_lamp = {
      {{"kind", "point"}, {"at", {-30, -60, 57}}},
      {{"kind", "directional"}, {"to", {1, 0, 0.5}}, {"color", {0.1, 0.9, 0.4}}}};
  for (const json& lamps : {grey_lamp, coloured_lamp}) {
    const Scene scene = scene_of({{"surface", {{{"iso", 0.5}}}},
                                  {"ambient", {0.1, 0.1, 0.1}},
                                  {"background", {0.3, 0.1, 0.7}},
                                  {"light", lamps}});
    const SurfaceBuffer buffer = RayCaster(scene).cast(*scene.camera);
    const Radiance radiance = light(scene, buffer);
    LitPicture lit;
    const Picture& picture = lit.relight(scene, buffer);
    int grey = 0, coloured = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Rgb total = radiance.total.at(buffer.at(x, y));
        if (buffer.sample(buffer.at(x, y)).is_hit()) {
          ++(total.r == total.g && total.g == total.b ? grey : coloured);
        }
        const auto expected = displayed(scene.display, total);
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_EQ(picture.rgb[3 * static_cast<std::size_t>(y * kWidth + x) + c], expected[c])
              << x << ", " << y;
        }
      }
    }
    EXPECT_GT(grey, 50);
    EXPECT_EQ(coloured > 50, lamps == coloured_lamp);
  }
}

TEST(Relight, a_picture_drawn_again_and_again_is_the_picture_drawn_once) {
  std::mt19937 random(3);
  const auto any = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  LitPicture again;
  for (int n = 0; n < 30; ++n) {
    json changes = {{"exposure", any(0.2, 2)}};
    if (n % 3 == 0) changes["background"] = {any(0, 1), any(0, 1), any(0, 1)};
    changes["camera"] = {{"eye", {any(-90, 90), -90, any(-90, 90)}},
                         {"target", {any(-20, 20), 0, 0}}};
    const Scene scene = scene_of(changes);
    const SurfaceBuffer buffer = RayCaster(scene).cast(*scene.camera);
    LitPicture once;
    EXPECT_EQ(again.relight(scene, buffer).rgb, once.relight(scene, buffer).rgb);
  }
}

TEST(Relight, another_display_draws_the_bytes_that_lighting_anew_would) {
  json settings = {{"exposure", 1}};
  const Scene scene = scene_of(settings);
  const SurfaceBuffer buffer = RayCaster(scene).cast(*scene.camera);
  LitPicture picture;
  picture.relight(scene, buffer);
  settings = {{"exposure", 0.3}, {"display", "raw"}};
  const Scene darker = scene_of(settings);
  const std::vector<std::uint8_t> shown = picture.redisplay(darker, buffer).rgb;
  EXPECT_EQ(shown, LitPicture().relight(darker, buffer).rgb);
}

TEST(Relight, a_tile_alone_has_the_bits_that_it_has_in_the_picture) {
  const Scene scene = scene_of(json::object());
  const RayCaster caster(scene);
  const SurfaceBuffer buffer = caster.cast(*scene.camera);
  const Radiance radiance = light(scene, buffer);
  for (int y = 0; y < kHeight; y += 3) {
    for (int x = 0; x < kWidth; x += 2) {
      const SurfaceBuffer tile = caster.cast_around(*scene.camera, x, y).buffer;
      const std::size_t place = tile.at(x - tile.first_x, y - tile.first_y);
      EXPECT_EQ(light(scene, tile).total.at(place), radiance.total.at(buffer.at(x, y)));
    }
  }
}

}  // namespace
}  // namespace isolux
