#include "isolux/mesh/weld.h"

#include <gtest/gtest.h>

namespace isolux {
namespace {

// Two triangles of a square, with six vertices of their own and one that nobody uses.
Mesh square_as_soup() {
  Mesh mesh;
  mesh.positions = {{9, 9, 9},     {0, 0, 0}, {1, 0, 0}, {1, 1, 0},
                    {-0.0f, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{1, 2, 3}, {4, 5, 6}};
  return mesh;
}

TEST(Weld, equal_vertices_become_one_and_unused_ones_go) {
  Mesh mesh = square_as_soup();
  weld(mesh);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Mesh::Triangle>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Weld, vertices_that_differ_in_a_normal_stay_apart_but_not_by_position) {
  Mesh mesh = square_as_soup();
  mesh.normals.assign(7, {0, 0, 1});
  mesh.normals[4] = {0, 0, -1};
  weld(mesh);
  EXPECT_EQ(mesh.positions.size(), 5u);
  EXPECT_EQ(mesh.normals[mesh.triangles[1][0]], (Vec3f{0, 0, -1}));
  EXPECT_EQ(welded_by_position(mesh).positions.size(), 4u);
}

}  // namespace
}  // namespace isolux
