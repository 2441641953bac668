#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/image/png.h"
#include "isolux/io/mesh_encoders.h"
#include "isolux/io/reader.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/mesh/mesh_box.h"
#include "isolux/mesh/mesh_topology.h"
#include "isolux/mesh/weld.h"
#include "isolux/volume/phantom.h"
#include "shared_data.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

class ReadMesh : public TemporaryFolder {
 protected:
  std::string write(const std::string& name, const std::string& bytes) {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  ReadResult read(const std::string& name, const std::string& bytes) {
    return read_input({write(name, bytes), {}});
  }
};

Mesh ball() { return extract_isosurface(sphere_phantom(17), 0.501); }

double six_volumes(const Mesh& mesh) {
  double sum = 0;
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, triangle);
    sum += dot(a, cross(b, c));
  }
  return sum;
}

TEST_F(ReadMesh, what_is_written_is_read_back_in_every_format_and_space) {
  Mesh mesh = ball();
  mesh.colors.assign(mesh.positions.size(), {1, 0.5f, 0});
  const struct {
    const char* name;
    std::string bytes;
    bool has_normals;
  } cases[] = {{"a.stl", as_stl(mesh, MeshSpace::kLps), false},
               {"b.stl", as_stl(mesh, MeshSpace::kRas), false},
               {"a.ply", as_ply(mesh, MeshSpace::kLps), true},
               {"b.ply", as_ply(mesh, MeshSpace::kRas), true},
               {"a.obj", as_obj(mesh, MeshSpace::kLps), true},
               {"b.obj", as_obj(mesh, MeshSpace::kRas), true},
               {"a.glb", as_glb(mesh, MeshSpace::kLps), true},
               {"an.unknown-ending", as_ply(mesh, MeshSpace::kLps), true}};
  for (const auto& [name, bytes, has_normals] : cases) {
    const auto result = read(name, bytes);
    const Mesh& back = *result.mesh;
    ASSERT_EQ(back.triangles.size(), mesh.triangles.size()) << name;
    EXPECT_TRUE(topology_of(welded_by_position(back)).is_watertight()) << name;
    EXPECT_EQ(!back.normals.empty(), has_normals) << name;
    for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t was = mesh.triangles[n][c], is = back.triangles[n][c];
        // Metres and back again: the last bits of 16 mm.
        EXPECT_LT(length(as_double(back.positions[is]) - as_double(mesh.positions[was])), 3e-6);
        if (!has_normals) continue;
        EXPECT_LT(length(as_double(back.normals[is]) - as_double(mesh.normals[was])), 1e-6);
        EXPECT_NEAR(back.colors[is].y, 0.5, 0.004) << name;  // a byte of sRGB
      }
    }
  }
}

TEST_F(ReadMesh, an_obj_has_materials_and_a_texture_beside_it) {
  const Picture red{1, 1, {255, 0, 0}};
  write("red.png", encode_png(red, {}, true));
  write("a.mtl",
        "newmtl shiny\nKa 0.1 0 0\nKd 0.5 0.25 1\nKs 2 0 0\nNs 77\nmap_Kd red.png\nnewmtl dull\n"
        "Kd 0 1 0\n");
  const auto result = read("a.obj",
                           "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\n"
                           "vt 0 1\nusemtl shiny\nf 1/1 2/2 3/3\nusemtl dull\nf 1 2 4\n");
  const Mesh& mesh = *result.mesh;
  ASSERT_EQ(mesh.parts.size(), 2u);
  const MeshMaterial& shiny = mesh.materials[mesh.parts[0].material];
  EXPECT_EQ(shiny.name, "shiny");
  EXPECT_EQ(shiny.material.kd, (Rgb{0.5, 0.25, 1}));
  EXPECT_EQ(shiny.material.ks, (Rgb{1, 0, 0}));  // clamped, and told
  EXPECT_EQ(shiny.material.shininess, 77);
  ASSERT_NE(shiny.base_color, nullptr);
  EXPECT_EQ(shiny.base_color->rgb, red.rgb);
  EXPECT_EQ(mesh.materials[mesh.parts[1].material].material.kd, (Rgb{0, 1, 0}));
  const TexturePoint second = mesh.texture_points[mesh.triangles[0][1]];
  EXPECT_EQ(second.u, 1);
  EXPECT_EQ(second.v, 0);
  EXPECT_EQ(result.notes.size(), 1u);
  EXPECT_EQ(result.files.size(), 3u);  // for the checksums that a picture carries
}

TEST_F(ReadMesh, what_is_missing_or_lies_elsewhere_is_told_and_done_without) {
  write("secret.mtl", "newmtl m\nKd 1 0 0\n");
  std::filesystem::create_directory(folder_ / "below");
  for (const std::string library : {"none.mtl", "../secret.mtl", "/etc/passwd"}) {
    const auto result = read(
        "below/a.obj", "mtllib " + library + "\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    ASSERT_EQ(result.notes.size(), 1u) << library;
    EXPECT_NE(result.notes[0].find(library), std::string::npos) << result.notes[0];
    EXPECT_EQ(result.mesh->materials[0].material.kd, Material{}.kd);
    EXPECT_EQ(result.files.size(), 1u);
  }
  write("t.mtl", "newmtl m\nKd 1 0 0\nmap_Kd ../picture.png\n");
  const auto result = read("t.obj", "mtllib t.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(result.mesh->materials[0].base_color, nullptr);
  EXPECT_EQ(result.notes.size(), 1u);
}

// A tetrahedron with outward triangles, as glTF without its nodes.
std::string gltf(const std::string& nodes) {
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": )" +
         nodes + R"(, "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 1]},
                  {"bufferView": 1, "componentType": 5125, "count": 12, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 48},
                    {"buffer": 0, "byteOffset": 48, "byteLength": 48}],
    "buffers": [{"byteLength": 96, "uri": "t.bin"}]})";
}

class ReadGltf : public ReadMesh {
 protected:
  void SetUp() override {
    ReadMesh::SetUp();
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::uint32_t indices[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    write("t.bin", std::string(reinterpret_cast<const char*>(positions), sizeof positions) +
                       std::string(reinterpret_cast<const char*>(indices), sizeof indices));
  }
};

TEST_F(ReadGltf, nodes_move_turn_scale_and_mirror_without_turning_inside_out) {
  // Twice as long along x, mirrored at y = 0, then moved by 3 along y: in metres, +y up.
  const auto result = read("t.gltf", gltf(R"([{"children": [1], "translation": [0, 3, 0]},
                                              {"mesh": 0, "scale": [2, -1, 1]}])"));
  const Mesh& mesh = *result.mesh;
  EXPECT_NEAR(six_volumes(mesh), 2e9, 1e3);  // 2 m^3 / 6, outward
  const MeshBox box = box_of(mesh);
  EXPECT_LT(length(box.low - Vec3{0, -1000, 2000}), 1e-3);
  EXPECT_LT(length(box.high - Vec3{2000, 0, 3000}), 1e-3);
}

TEST_F(ReadGltf, one_mesh_may_hang_on_several_nodes) {
  const auto result = read("t.gltf", gltf(R"([{"mesh": 0, "children": [1]},
                                              {"mesh": 0, "translation": [5, 0, 0]}])"));
  EXPECT_EQ(result.mesh->triangles.size(), 8u);
}

TEST_F(ReadGltf, hostile_files_are_refused) {
  std::string cycle = R"([{"children": [1]}, {"children": [0], "mesh": 0}])";
  EXPECT_THROW(read("cycle.gltf", gltf(cycle)), WorkError);
  // 2^40 meshes out of 41 nodes, each named twice as a child.
  std::string nodes = "[";
  for (int n = 0; n < 40; ++n) {
    const std::string next = std::to_string(n + 1);
    nodes += "{\"children\": [" + next + ", " + next + "]}, ";
  }
  EXPECT_THROW(read("bomb.gltf", gltf(nodes + "{\"mesh\": 0}]")), WorkError);
  std::string outside = gltf(R"([{"mesh": 0}])");
  outside.replace(outside.find("t.bin"), 5, "/dev/zero");
  EXPECT_THROW(read("outside.gltf", outside), WorkError);
}

TEST_F(ReadMesh, bad_triangles_are_left_out_and_told) {
  const auto result = read(
      "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 0 0 0\nf 1 2 3\nf 1 2 4\nf 1 5 2\nl 1 2\n");
  EXPECT_EQ(result.mesh->triangles.size(), 1u);
  EXPECT_GE(result.notes.size(), 2u);
}

TEST_F(ReadMesh, counts_that_the_bytes_cannot_hold_are_refused_before_memory_is_taken) {
  std::string stl(84, ' ');
  stl[80] = stl[81] = stl[82] = stl[83] = '\x7f';
  EXPECT_THROW(read("a.stl", stl), WorkError);
  EXPECT_THROW(read("a.ply",
                    "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\n"
                    "property float y\nproperty float z\nelement face 1\n"
                    "property list uchar int vertex_indices\nend_header\n0 0 0\n3 0 0 0\n"),
               WorkError);
}

TEST_F(ReadMesh, every_shared_mesh_loads) {
  ISOLUX_NEEDS("meshes/bunny.ply");
  const struct {
    const char* name;
    std::size_t triangles;
  } cases[] = {{"bunny.ply", 69451},
               {"teapot.obj", 6320},
               {"cornell_box.obj", 36},
               {"Duck.glb", 4212},
               {"adi_brain_mesh.stl", 9600},
               {"cube_binary.ply", 12},
               {"BoxTextured/BoxTextured.gltf", 12},
               {"triangle_with_two_solids.stl", 2}};
  for (const auto& [name, triangles] : cases) {
    const auto result = read_input({shared_data(std::string("meshes/") + name), {}});
    EXPECT_EQ(result.mesh->triangles.size(), triangles) << name;
  }
}

TEST_F(ReadMesh, a_bad_shared_mesh_is_refused_or_read_but_harms_nothing) {
  ISOLUX_NEEDS("bad/obj");
  for (const char* folder : {"bad/obj", "bad/ply", "bad/stl", "bad/gltf"}) {
    for (const auto& entry : std::filesystem::directory_iterator(shared_data(folder))) {
      try {
        EXPECT_FALSE(read_input({entry.path().string(), {}}).mesh->triangles.empty());
      } catch (const WorkError&) {
      }
    }
  }
}

}  // namespace
}  // namespace isolux
