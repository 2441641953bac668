#include "isolux/scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/base/exact_math.h"
#include "isolux/scene/document.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

std::shared_ptr<const Volume> placed_sphere() {
  auto volume = std::make_shared<Volume>(sphere_phantom(9));
  // Index axes turned about z by a quarter and stretched: i -> +y by 2, j -> -x by 3, k -> +z by 5.
  volume->world_from_index = {{{{0, 2, 0}, {-3, 0, 0}, {0, 0, 5}}}, {100, 200, 300}};
  return volume;
}

Scene resolved(const json& settings, int volumes = 1) {
  json document = empty_document();
  document.update(settings);
  SceneDescription description = describe(document, "scene");
  description.inputs.assign(static_cast<std::size_t>(volumes), "a volume");
  return resolve(description, std::vector<SceneInput>(static_cast<std::size_t>(volumes),
                                                      SceneInput{placed_sphere()}));
}

TEST(Scene, a_point_light_in_index_space_lies_where_the_voxel_lies) {
  const Scene scene =
      resolved({{"light", {{{"kind", "point"}, {"at", {1, 2, 3}}, {"space", "index"}}}}});
  EXPECT_EQ(scene.lights[0].place, (Vec3{100 - 6, 200 + 2, 300 + 15}));
}

TEST(Scene, a_vector_in_index_space_goes_through_the_matrix_alone) {
  const Scene scene =
      resolved({{"light", {{{"kind", "directional"}, {"to", {1, 2, 3}}, {"space", "index"}}}}});
  EXPECT_EQ(scene.lights[0].place, (Vec3{-6, 2, 15}));
}

TEST(Scene, a_light_on_the_camera_moves_with_it) {
  const Scene scene =
      resolved({{"camera", {{"eye", {0, -50, 0}}, {"target", {0, 0, 0}}}},
                {"light",
                 {{{"kind", "point"}, {"at", {1, 2, 3}}, {"attach", "camera"}},
                  {{"kind", "directional"}, {"to", {1, 2, 3}}, {"attach", "camera"}}}}});
  // Right is +x, up is +z, towards the viewer is -y.
  EXPECT_EQ(scene.lights[0].place, (Vec3{1, -53, 2}));
  EXPECT_EQ(scene.lights[1].place, (Vec3{1, -3, 2}));
}

TEST(Scene, without_a_light_one_shines_from_the_eye) {
  const Scene scene = resolved({{"camera", {{"view", "left"}}}});
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].kind, Light::Kind::kDirectional);
  EXPECT_EQ(scene.lights[0].place, (Vec3{1, 0, 0}));
  EXPECT_EQ(scene.ambient, (Rgb{1, 1, 1}));
}

TEST(Scene, ambient_is_the_sum_of_intensities_unless_given) {
  const json lights = {
      {{"kind", "point"}, {"at", {0, 0, 0}}, {"color", {1, 0.5, 0}}, {"intensity", 2}},
      {{"kind", "directional"}, {"to", {0, 0, 1}}, {"color", {0, 0.5, 1}}}};
  EXPECT_EQ(resolved({{"light", lights}}).ambient, (Rgb{2, 1.5, 1}));
  EXPECT_EQ(resolved({{"light", lights}, {"ambient", {0, 0, 0.25}}}).ambient, (Rgb{0, 0, 0.25}));
}

TEST(Scene, without_a_surface_every_volume_shows_its_first_suggestion) {
  EXPECT_EQ(resolved(json::object(), 2).surfaces.size(), 2u);
}

TEST(Scene, an_input_that_is_not_there_is_refused) {
  EXPECT_THROW(resolved({{"surface", {{{"iso", 0.5}, {"input", 2}}}}}), UsageError);
  EXPECT_NO_THROW(resolved({{"surface", {{{"iso", 0.5}, {"input", 2}}}}}, 2));
}

// A red triangle and one in the material of the second.
std::shared_ptr<const Mesh> two_triangles() {
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{0, 0, 0}, {10, 0, 0}, {0, 20, 0}, {0, 0, 30}};
  mesh->triangles = {{0, 1, 2}, {0, 1, 3}};
  mesh->materials.resize(2);
  mesh->materials[0].material.kd = {1, 0, 0};
  mesh->parts = {{0, 1, 0}, {1, 1, 1}};
  return mesh;
}

Scene resolved_with_mesh(const json& settings, bool with_volume) {
  json document = empty_document();
  document.update(settings);
  SceneDescription description = describe(document, "scene");
  std::vector<SceneInput> inputs;
  if (with_volume) inputs.push_back({placed_sphere()});
  inputs.push_back({nullptr, two_triangles()});
  description.inputs.assign(inputs.size(), "an input");
  return resolve(description, inputs);
}

TEST(Scene, surfaces_are_those_named_then_suggested_ones_then_other_meshes) {
  const Scene none_named = resolved_with_mesh(json::object(), true);
  ASSERT_EQ(none_named.surfaces.size(), 2u);
  EXPECT_NE(none_named.surfaces[0].volume, nullptr);
  EXPECT_NE(none_named.surfaces[1].mesh, nullptr);
  const Scene mesh_first =
      resolved_with_mesh({{"surface", {{{"input", 2}, {"ks", {0, 0, 0}}}, {{"iso", 0.5}}}}}, true);
  ASSERT_EQ(mesh_first.surfaces.size(), 2u);
  EXPECT_NE(mesh_first.surfaces[0].mesh, nullptr);
  EXPECT_EQ(mesh_first.surfaces[1].iso, 0.5);
}

TEST(Scene, a_mesh_keeps_the_coefficients_that_nobody_changes) {
  const Scene scene =
      resolved_with_mesh({{"surface", {{{"input", 1}, {"ks", {0, 0.5, 0}}}}}}, false);
  const SurfaceItem& item = scene.surfaces[0];
  EXPECT_TRUE(item.is_painted);
  EXPECT_EQ(material_at(item, {0, 0, 0}).kd, (Rgb{1, 0, 0}));
  EXPECT_EQ(material_at(item, {1, 0, 0}).kd, Material{}.kd);
  EXPECT_EQ(material_at(item, {1, 0, 0}).ks, (Rgb{0, 0.5, 0}));
}

TEST(Scene, named_views_fit_meshes_too) {
  // The box is 10 x 20 x 30 mm: its sphere has the radius sqrt(1400) / 2 = 18.7 mm.
  const Scene scene = resolved_with_mesh(json::object(), false);
  const Ray ray = scene.camera->ray(0, 0);
  EXPECT_NEAR(length(ray.origin - Vec3{5, 10, 15}), std::sqrt(350.0) / std::sin(exact::radians(15)),
              1e-9);
}

TEST(Scene, iso_values_are_for_volumes_and_index_space_is_theirs) {
  const auto with_surface = [](const json& surface, bool with_volume) {
    return resolved_with_mesh({{"surface", {surface}}}, with_volume);
  };
  EXPECT_THROW(with_surface({{"ka", {0, 0, 0}}}, true), UsageError);  // the volume: no iso value
  EXPECT_THROW(with_surface({{"iso", 1}, {"input", 2}}, true), UsageError);
  EXPECT_THROW(with_surface({{"iso", 1}}, false), UsageError);
  const json light = {{"kind", "point"}, {"at", {0, 0, 0}}, {"space", "index"}};
  EXPECT_THROW(resolved_with_mesh({{"light", {light}}}, false), UsageError);
  EXPECT_NO_THROW(resolved_with_mesh({{"light", {light}}}, true));
}

}  // namespace
}  // namespace isolux
