#include "isolux/scene/description.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/scene/document.h"

namespace isolux {
namespace {

using nlohmann::json;

json scene_with(const char* key, const json& value) {
  json document = empty_document();
  document[key] = value;
  return document;
}

TEST(Document, numbers_are_written_in_one_way_whether_they_are_whole_or_not) {
  json whole = empty_document(), written = empty_document();
  whole["surface"] = {{{"iso", 300}, {"kd", {1, 0, 0}}}, {{"input", 2}, {"shininess", 4}}};
  whole["camera"] = {{"fov", 18}};
  written["surface"] = {{{"iso", 300.0}, {"kd", {1.0, 0.0, 0.0}}},
                        {{"input", 2}, {"shininess", 4.0}}};
  written["camera"] = {{"fov", 18.0}};
  EXPECT_EQ(with_defaults(whole).dump(), with_defaults(written).dump());
}

TEST(Description, an_empty_scene_has_the_contracts_defaults) {
  const SceneDescription scene = describe(empty_document(), "scene");
  EXPECT_TRUE(scene.inputs.empty());
  EXPECT_TRUE(scene.surfaces.empty());
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_FALSE(scene.ambient);
  EXPECT_EQ(scene.width, 1024);
  EXPECT_EQ(scene.height, 1024);
  EXPECT_EQ(scene.camera.view, "front");
  EXPECT_EQ(scene.camera.fov_deg, 30);
  EXPECT_EQ(scene.display.exposure, 1);
  EXPECT_EQ(scene.display.curve, Display::Curve::kSrgb);
  EXPECT_EQ(scene.background, Rgb{});
}

TEST(Description, a_surface_has_the_contracts_material) {
  const auto scene = describe(scene_with("surface", {{{"iso", 300}}}), "scene");
  ASSERT_EQ(scene.surfaces.size(), 1u);
  const Material material = scene.surfaces[0].change.applied({});
  EXPECT_EQ(material.ka, (Rgb{.1, .1, .1}));
  EXPECT_EQ(material.kd, (Rgb{.8, .8, .8}));
  EXPECT_EQ(material.ks, (Rgb{.3, .3, .3}));
  EXPECT_EQ(material.shininess, 40);
}

TEST(Description, what_does_not_go_together_is_refused) {
  const json kBadLights[] = {
      {{"kind", "point"}},
      {{"kind", "point"}, {"to", {0, 0, 1}}, {"at", {0, 0, 1}}},
      {{"kind", "directional"}, {"to", {0, 0, 0}}},
      {{"kind", "directional"}, {"to", {0, 0, 1}}, {"falloff", "inverse-square"}},
      {{"kind", "point"}, {"at", {0, 0, 1}}, {"reference", 10}},
      {{"kind", "point"}, {"at", {0, 0, 1}}, {"input", 1}},
      {{"kind", "point"}, {"at", {0, 0, 1}}, {"space", "index"}, {"attach", "camera"}},
      {{"at", {0, 0, 1}}},
  };
  for (const json& light : kBadLights) {
    EXPECT_THROW(describe(scene_with("light", json::array({light})), "scene"), UsageError) << light;
  }
  const json kBadCameras[] = {
      {{"view", "front"}, {"eye", {0, 0, 1}}},
      {{"up", {0, 0, 1}}},
      {{"projection", "orthographic"}, {"fov", 30}},
      {{"height", 30}},
  };
  for (const json& camera : kBadCameras) {
    EXPECT_THROW(describe(scene_with("camera", camera), "scene"), UsageError) << camera;
  }
}

TEST(Document, unknown_keys_wrong_versions_and_wrong_types_are_refused) {
  EXPECT_THROW(check_document(json::array(), "f"), UsageError);
  EXPECT_THROW(check_document({{"isolux_scene", 2}}, "f"), UsageError);
  EXPECT_THROW(check_document(scene_with("surfaces", json::array()), "f"), UsageError);
  EXPECT_THROW(check_document(scene_with("surface", {{"iso", 1}}), "f"), UsageError);
  EXPECT_THROW(check_document(scene_with("size", {1.5, 2}), "f"), UsageError);
  EXPECT_THROW(check_document(scene_with("input", "head.nrrd"), "f"), UsageError);
  EXPECT_NO_THROW(check_document(scene_with("input", {"head.nrrd"}), "f"));
}

TEST(Document, its_command_says_the_same_ready_for_a_shell) {
  json document = scene_with("input", {"my head's.nrrd"});
  document["surface"] = {{{"iso", 300}, {"ka", {0, 0.5, 1}}}};
  EXPECT_EQ(command_of(document),
            "isolux render 'my head'\\''s.nrrd' --surface iso=300,ka=0:0.5:1");
}

}  // namespace
}  // namespace isolux
