#include "isolux/render/ray_caster.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "isolux/scene/document.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

struct OracleHit {
  double t;
  std::int32_t surface;
};

// The nearest of all surfaces, by the plain walker.
std::optional<OracleHit> oracle_hit(const std::vector<IsoSurface>& surfaces, const Ray& ray) {
  std::optional<OracleHit> nearest;
  for (std::size_t n = 0; n < surfaces.size(); ++n) {
    const auto hit = surfaces[n].first_hit(ray);
    if (hit && (!nearest || hit->t < nearest->t)) nearest = {hit->t, static_cast<std::int32_t>(n)};
  }
  return nearest;
}

// A skull in a skin, on a grid that is turned, sheared and not cubic.
class RayCasterTest : public testing::TestWithParam<json> {
 protected:
  static std::shared_ptr<const Volume> head() {
    Volume volume = head_phantom(48);
    Affine& place = volume.world_from_index;
    place.linear = Mat3{{{0.8, 0.1, 0}, {-0.1, 1.1, 0.3}, {0.05, 0, 1.4}}} * place.linear;
    return std::make_shared<const Volume>(std::move(volume));
  }
};

TEST_P(RayCasterTest, every_pixel_is_what_the_plain_walker_finds) {
  json document = empty_document();
  document["size"] = {45, 38};  // neither a whole number of tiles nor of blocks
  document["surface"] = {{{"iso", 300}}, {{"iso", -300}}};
  document["camera"] = GetParam();
  SceneDescription description = describe(document, "scene");
  description.inputs = {"phantom:head"};
  const Scene scene = resolve(description, {head()});
  const auto bricks = std::make_shared<const BrickGrid>(*scene.surfaces[0].volume);
  std::vector<IsoSurface> oracle;
  for (const IsoSurfaceItem& item : scene.surfaces) {
    oracle.emplace_back(item.volume, bricks, item.iso);
  }
  const SurfaceBuffer buffer = RayCaster(scene).cast(*scene.camera);
  int hits = 0;
  for (int y = 0; y < 38; ++y) {
    for (int x = 0; x < 45; ++x) {
      const auto expected = oracle_hit(oracle, scene.camera->ray(x, y));
      const SurfaceSample found = buffer.sample(buffer.at(x, y));
      ASSERT_EQ(found.is_hit(), expected.has_value()) << x << "," << y;
      if (!expected) continue;
      ++hits;
      EXPECT_EQ(found.surface, expected->surface) << x << "," << y;
      EXPECT_NEAR(found.depth_mm, expected->t, 1e-3) << x << "," << y;
      EXPECT_LE(dot(found.normal(), scene.camera->ray(x, y).direction), 1e-6);
    }
  }
  EXPECT_GT(hits, 50);
}

INSTANTIATE_TEST_SUITE_P(
    Cameras, RayCasterTest,
    testing::Values(json{{"view", "front"}}, json{{"view", "top"}, {"projection", "orthographic"}},
                    json{{"view", "left"}, {"projection", "orthographic"}, {"height", 60}},
                    json{{"eye", {0, 0, 0}}, {"target", {100, 30, 20}}, {"fov", 120}},  // inside
                    json{{"eye", {3, -120, 10}}, {"target", {0, 0, 0}}, {"fov", 60}},
                    json{{"eye", {0, -60, 0}}, {"target", {0, 100, 5}}, {"fov", 100}},
                    json{{"eye", {2000, -3000, 900}}, {"target", {0, 0, 0}}, {"fov", 4}}));

}  // namespace
}  // namespace isolux
