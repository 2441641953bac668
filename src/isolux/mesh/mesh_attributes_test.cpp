#include "isolux/mesh/mesh_attributes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isolux {
namespace {

// Two triangles with the corners (0, 0), (1, 0), (0, 1) in z = 0 and z = 1, each with its material.
Mesh two_triangles() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  mesh.materials.resize(2);
  mesh.materials[1].material.kd = {0.5, 0.5, 0.5};
  mesh.parts = {{0, 1, 1}, {1, 1, 0}};
  return mesh;
}

TEST(MeshAttributes, normals_are_blended_or_the_triangles_own) {
  Mesh mesh = two_triangles();
  EXPECT_EQ(shading_normal(mesh, {0, 0.3f, 0.3f}), (Vec3{0, 0, 1}));
  mesh.normals = {{0, 0, 1}, {1, 0, 0}, {0, 0, 1}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const Vec3 half_way = shading_normal(mesh, {0, 0.5f, 0});
  EXPECT_NEAR(half_way.x, std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(half_way.z, std::sqrt(0.5), 1e-15);
  EXPECT_EQ(shading_normal(mesh, {1, 0.5f, 0}), (Vec3{0, 0, 1}));  // zeros say: its own
}

TEST(MeshAttributes, each_triangle_has_the_material_of_its_part) {
  const Mesh mesh = two_triangles();
  EXPECT_EQ(material_at(mesh, {0, 0, 0}).kd, (Rgb{0.5, 0.5, 0.5}));
  EXPECT_EQ(material_at(mesh, {1, 0, 0}).kd, Material{}.kd);
}

TEST(MeshAttributes, a_mesh_of_one_plain_material_has_one_material) {
  Mesh mesh = two_triangles();
  EXPECT_FALSE(has_one_material(mesh));
  mesh.parts = {{0, 2, 1}};
  EXPECT_TRUE(has_one_material(mesh));
  mesh.materials[1].base_color = std::make_shared<const Picture>();
  EXPECT_FALSE(has_one_material(mesh));
}

TEST(MeshAttributes, colours_and_texture_multiply_ka_and_kd) {
  Mesh mesh = two_triangles();
  mesh.colors.assign(6, {1, 0.5f, 0});
  // Two pixels side by side, white and black: centres at u = 1/4 and 3/4.
  mesh.materials[1].base_color =
      std::make_shared<const Picture>(Picture{2, 1, {255, 255, 255, 0, 0, 0}});
  mesh.texture_points = {{0, 0}, {1, 0}, {0, 1}, {0, 0}, {0, 0}, {0, 0}};
  EXPECT_EQ(material_at(mesh, {0, 0.25f, 0.5f}).kd, (Rgb{0.5, 0.25, 0}));
  EXPECT_EQ(material_at(mesh, {0, 0.75f, 0.1f}).kd, (Rgb{0, 0, 0}));
  EXPECT_NEAR(material_at(mesh, {0, 0.5f, 0}).kd.r, 0.25, 1e-12);  // half way between them
  EXPECT_NEAR(material_at(mesh, {0, 0, 0}).kd.r, 0.25, 1e-12);     // and where it repeats
  EXPECT_EQ(material_at(mesh, {0, 0.25f, 0}).ks, Material{}.ks);
}

}  // namespace
}  // namespace isolux
