#include "isolux/io/write_mesh.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "isolux/base/error.h"
#include "isolux/io/mesh_encoders.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

class WriteMesh : public TemporaryFolder {};

// One triangle that faces up (+z), in red.
Mesh red_triangle() {
  Mesh mesh;
  mesh.positions = {{1, 2, 3}, {4, 2, 3}, {1, 6, 3}};
  mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  mesh.colors = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.materials.resize(1);
  mesh.materials[0].material.kd = {0.5, 0.25, 1};
  mesh.parts = {{0, 1, 0}};
  return mesh;
}

std::vector<float> floats(const std::string& bytes, std::size_t at, std::size_t count) {
  std::vector<float> values(count);
  std::memcpy(values.data(), bytes.data() + at, count * sizeof(float));
  return values;
}

TEST_F(WriteMesh, binary_stl_is_a_header_with_the_tag_a_count_and_facets) {
  const std::string lps = as_stl(red_triangle(), MeshSpace::kLps);
  ASSERT_EQ(lps.size(), 80u + 4 + 50);
  EXPECT_FALSE(lps.starts_with("solid"));  // that would make it text
  EXPECT_NE(lps.substr(0, 80).find("SPACE=LPS"), std::string::npos);
  EXPECT_EQ(floats(lps, 84, 12), (std::vector<float>{0, 0, 1, 1, 2, 3, 4, 2, 3, 1, 6, 3}));
  const std::string ras = as_stl(red_triangle(), MeshSpace::kRas);
  EXPECT_NE(ras.substr(0, 80).find("SPACE=RAS"), std::string::npos);
  EXPECT_EQ(floats(ras, 84, 12), (std::vector<float>{0, 0, 1, -1, -2, 3, -4, -2, 3, -1, -6, 3}));
}

TEST_F(WriteMesh, ply_says_in_its_header_what_follows) {
  const std::string ply = as_ply(red_triangle(), MeshSpace::kLps);
  const std::size_t data = ply.find("end_header\n") + 11;
  EXPECT_NE(ply.find("comment isolux, mm, SPACE=LPS\n"), std::string::npos);
  EXPECT_EQ(ply.size() - data, 3 * (6 * 4 + 3) + 1 + 3 * 4u);
  EXPECT_EQ(floats(ply, data, 6), (std::vector<float>{1, 2, 3, 0, 0, 1}));
  EXPECT_EQ(ply.substr(data + 24, 3), std::string("\xff\0\0", 3));
}

TEST_F(WriteMesh, obj_counts_from_one_and_keeps_floats_whole) {
  Mesh mesh = red_triangle();
  mesh.colors.clear();
  mesh.positions[0].x = 0.1f;
  EXPECT_EQ(as_obj(mesh, MeshSpace::kRas),
            "# isolux, mm, SPACE=RAS\nv -0.1 -2 3\nv -4 -2 3\nv -1 -6 3\n"
            "vn -0 -0 1\nvn -0 -0 1\nvn -0 -0 1\nf 1//1 2//2 3//3\n");
}

TEST_F(WriteMesh, glb_is_lps_under_a_node_that_stands_it_upright_in_metres) {
  const std::string glb = as_glb(red_triangle(), MeshSpace::kLps);
  std::uint32_t words[5];
  std::memcpy(words, glb.data(), sizeof words);
  EXPECT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(words[2], glb.size());
  const auto document = nlohmann::json::parse(glb.substr(20, words[3]));
  // Superior (0, 0, 1) mm is up (0, 0.001, 0) m; anterior (0, -1, 0) is the front (0, 0, 0.001).
  const std::vector<double> m = document["nodes"][0]["matrix"];
  EXPECT_EQ((std::vector<double>{m[8], m[9], m[10]}), (std::vector<double>{0, 0.001, 0}));
  EXPECT_EQ((std::vector<double>{-m[4], -m[5], -m[6]}), (std::vector<double>{0, 0, 0.001}));
  const auto& material = document["materials"][0];
  EXPECT_EQ(material["pbrMetallicRoughness"]["baseColorFactor"],
            (std::vector<double>{0.5, 0.25, 1, 1}));
  EXPECT_EQ(document["accessors"][0]["max"], (std::vector<double>{4, 6, 3}));
  const auto& primitive = document["meshes"][0]["primitives"][0];
  EXPECT_EQ(primitive["attributes"].size(), 3u);  // position, normal, colour
}

TEST_F(WriteMesh, the_ending_chooses_and_an_unknown_one_is_refused) {
  const std::string path = (folder_ / "a.stl").string();
  write_mesh(path, red_triangle(), MeshSpace::kLps);
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  EXPECT_EQ(bytes.str(), as_stl(red_triangle(), MeshSpace::kLps));
  EXPECT_THROW(check_mesh_name("a.vtk", MeshSpace::kLps), UsageError);
  EXPECT_THROW(check_mesh_name("a.glb", MeshSpace::kRas), UsageError);
}

TEST_F(WriteMesh, what_a_format_cannot_hold_is_told) {
  EXPECT_EQ(mesh_losses("a.stl", red_triangle()).size(), 2u);
  EXPECT_TRUE(mesh_losses("a.ply", red_triangle()).empty());
  Mesh textured = red_triangle();
  textured.materials[0].base_color = std::make_shared<const Picture>();
  EXPECT_EQ(mesh_losses("a.ply", textured).size(), 1u);
  EXPECT_TRUE(mesh_losses("a.glb", textured).empty());
}

}  // namespace
}  // namespace isolux
