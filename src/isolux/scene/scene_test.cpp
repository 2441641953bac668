#include "isolux/scene/scene.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
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
  return resolve(description, std::vector<std::shared_ptr<const Volume>>(
                                  static_cast<std::size_t>(volumes), placed_sphere()));
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

}  // namespace
}  // namespace isolux
