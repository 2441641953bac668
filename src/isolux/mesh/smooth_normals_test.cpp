#include "isolux/mesh/smooth_normals.h"

#include <gtest/gtest.h>

#include <cmath>

#include "isolux/mesh/extract_isosurface.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

// The sides of a box of 2 x 2 x 2 about the origin, two triangles each; corner n is at -1 or 1 by
// its bits.
Mesh box() {
  Mesh mesh;
  for (int n = 0; n < 8; ++n) {
    mesh.positions.push_back({n & 1 ? 1.0f : -1.0f, n & 2 ? 1.0f : -1.0f, n & 4 ? 1.0f : -1.0f});
  }
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  mesh.materials.resize(1);
  mesh.parts = {{0, 12, 0}};
  return mesh;
}

TEST(SmoothNormals, an_edge_sharper_than_the_crease_stays_sharp) {
  const Mesh sharp = with_smooth_normals(box(), 89);
  EXPECT_EQ(sharp.positions.size(), 24u);  // each side has its own four corners
  for (const Mesh::Triangle& t : sharp.triangles) {
    const auto [a, b, c] = corners(sharp, t);
    for (const std::uint32_t v : t) {
      EXPECT_EQ(as_double(sharp.normals[v]), normalize(cross(b - a, c - a)));
    }
  }
}

TEST(SmoothNormals, with_no_sharper_edge_the_corners_of_a_box_point_along_its_diagonals) {
  const Mesh smooth = with_smooth_normals(box(), 91);
  ASSERT_EQ(smooth.positions.size(), 8u);
  for (std::size_t v = 0; v < 8; ++v) {
    // One or two triangles of a side meet in a corner: 90 degrees in all.
    const Vec3 diagonal = normalize(as_double(smooth.positions[v]));
    EXPECT_LT(length(as_double(smooth.normals[v]) - diagonal), 1e-2);  // angles are that good
  }
}

TEST(SmoothNormals, on_a_sphere_they_point_away_from_its_middle) {
  // A side of a triangle is at most the diagonal of a cell's face, 2 sqrt(2) mm, on a radius of 16
  // mm. From its middle the sphere turns by no more than half that angle, 5 degrees; and the
  // triangles on all sides of a vertex mend most of it.
  const Mesh ball = extract_isosurface(sphere_phantom(33), 0.501);
  const Mesh smooth = with_smooth_normals(ball, 60);
  for (const Mesh::Triangle& t : smooth.triangles) {
    for (const std::uint32_t v : t) {
      const double cosine =
          dot(as_double(smooth.normals[v]), normalize(as_double(smooth.positions[v])));
      EXPECT_GT(cosine, std::cos(5 * 3.14159265358979 / 180));
    }
  }
}

TEST(SmoothNormals, seams_of_textures_are_smooth_and_what_vertices_carry_stays_with_them) {
  // Two halves of a slightly bent square, each with its own vertices and texture points.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0.1f}, {0, 1, 0}};
  mesh.texture_points = {{0, 0}, {1, 0}, {0, 1}, {0.5f, 0}, {1, 1}, {0, 0.5f}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  mesh.materials.resize(1);
  mesh.parts = {{0, 2, 0}};
  const Mesh smooth = with_smooth_normals(mesh, 30);
  ASSERT_EQ(smooth.triangles.size(), 2u);
  const auto normal = [&](std::size_t t, std::size_t corner) {
    return smooth.normals[smooth.triangles[t][corner]];
  };
  EXPECT_EQ(normal(0, 1), normal(1, 0));
  EXPECT_EQ(normal(0, 2), normal(1, 2));
  EXPECT_NE(normal(0, 0), normal(0, 1));
  EXPECT_EQ(smooth.texture_points[smooth.triangles[1][0]].u, 0.5f);
}

TEST(SmoothNormals, a_triangle_without_area_has_none_and_spoils_none) {
  Mesh mesh = box();
  mesh.positions.push_back({0, 1, 1});  // on the edge from corner 6 to corner 7
  mesh.triangles.push_back({6, 8, 7});
  mesh.parts[0].triangle_count = 13;
  const Mesh smooth = with_smooth_normals(mesh, 89);
  EXPECT_EQ(smooth.normals[smooth.triangles[12][1]], (Vec3f{0, 0, 0}));
  EXPECT_EQ(smooth.normals[smooth.triangles[10][2]], (Vec3f{0, 0, 1}));
}

}  // namespace
}  // namespace isolux
