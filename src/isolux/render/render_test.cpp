#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "isolux/base/parallel.h"
#include "isolux/render/explanation.h"
#include "isolux/render/pictures.h"
#include "isolux/render/ray_caster.h"
#include "isolux/render/relight.h"
#include "isolux/scene/document.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

Scene sphere_scene(const json& settings) {
  json document = empty_document();
  document["size"] = {32, 32};
  document["surface"] = {{{"iso", 0.5}}};
  document.update(settings);
  SceneDescription description = describe(document, "scene");
  description.inputs = {"phantom:sphere"};
  return resolve(description, {{std::make_shared<Volume>(sphere_phantom())}});
}

void expect_never(const SurfaceBuffer& buffer, std::int32_t surface) {
  for (std::size_t place = 0; place < buffer.pixels(); ++place) {
    EXPECT_NE(buffer.sample(place).surface, surface);
  }
}

TEST(Render, two_surfaces_of_one_volume_show_the_nearer) {
  // The sphere of iso 0.25 (radius 24) hides that of 0.5 (radius 16), whichever is named first.
  const Scene scene = sphere_scene({{"surface", {{{"iso", 0.5}}, {{"iso", 0.25}}}}});
  const SurfaceBuffer buffer = RayCaster(scene).cast(*scene.camera);
  expect_never(buffer, 0);
  EXPECT_EQ(buffer.sample(buffer.at(16, 16)).surface, 1);
}

TEST(Render, of_two_surfaces_in_one_place_the_first_is_seen) {
  const Scene scene = sphere_scene({{"surface", {{{"iso", 0.5}}, {{"iso", 0.5}}}}});
  const SurfaceBuffer buffer = RayCaster(scene).cast(*scene.camera);
  expect_never(buffer, 1);
}

TEST(Render, one_thread_and_many_give_the_same_bits_in_every_layer) {
  const Scene scene = sphere_scene({{"light",
                                     {{{"kind", "point"}, {"at", {-30, -60, 57}}},
                                      {{"kind", "directional"}, {"to", {1, 0, 0}}}}}});
  const auto layers_with = [&](int threads) {
    std::optional<Layers> layers;
    with_threads(threads, [&] {
      const SurfaceBuffer buffer = RayCaster(scene).cast(*scene.camera);
      layers = exr_layers(scene, buffer, light(scene, buffer));
    });
    return *layers;
  };
  const Layers one = layers_with(1), many = layers_with(7);
  for (const Layers::Channel& channel : one.channels) {
    EXPECT_EQ(channel.values, many.find(channel.name)->values) << channel.name;
    for (const float value : channel.values) EXPECT_FALSE(std::isnan(value)) << channel.name;
  }
}

TEST(Render, an_explanation_has_the_numbers_of_the_picture) {
  const Scene scene = sphere_scene({{"light", {{{"kind", "point"}, {"at", {-30, -60, 57}}}}}});
  const SurfaceBuffer buffer = RayCaster(scene).cast(*scene.camera);
  const Radiance radiance = light(scene, buffer);
  LitPicture lit;
  const Picture& picture = lit.relight(scene, buffer);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      const Explanation e = explain(scene, x, y);
      const std::size_t pixel = buffer.at(x, y);
      EXPECT_EQ(e.is_hit(), buffer.sample(pixel).is_hit());
      EXPECT_EQ(e.radiance, radiance.total.at(pixel));
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(e.total[c], e.radiance[c], 1e-5);
      }
      EXPECT_EQ(e.shown[1], picture.rgb[static_cast<std::size_t>(3 * (32 * y + x) + 1)]);
    }
  }
}

}  // namespace
}  // namespace isolux
