#include "isolux/intersect/mesh_distance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "isolux/mesh/extract_isosurface.h"
#include "isolux/volume/analytic_volume.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

MeshDistance distance_of_mesh(const Volume& volume, double iso, const Mesh& mesh) {
  const auto kept = std::make_shared<const Volume>(volume);
  return distance_between(mesh, {kept, std::make_shared<const BrickGrid>(*kept), iso});
}

TEST(MeshDistance, the_mesh_of_a_plane_lies_on_it) {
  const Volume plane = sample_on_cube<float>(9, 4, [](Vec3 p) { return p.x + 0.5 * p.y; });
  const Mesh mesh = extract_isosurface(plane, 0.3);
  const MeshDistance distance = distance_of_mesh(plane, 0.3, mesh);
  EXPECT_LT(distance.greatest_mm, 1e-6);  // positions are floats of up to 4 mm
}

TEST(MeshDistance, a_triangle_under_a_roof_is_as_far_from_it_as_its_centroid) {
  // |x| + z = 2 is a roof. Three of its points at z = 1, with the centroid at x = -1/3: the roof
  // is at z = 2 - 1/3 there, and the nearest vertex is 0.94 mm away.
  const Volume roof = sample_on_cube<float>(9, 4, [](Vec3 p) { return std::fabs(p.x) + p.z; });
  Mesh mesh;
  mesh.positions = {{-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}};
  mesh.triangles = {{0, 1, 2}};
  const MeshDistance distance = distance_of_mesh(roof, 2, mesh);
  EXPECT_NEAR(distance.mean_mm, 2.0 / 3, 1e-6);
  EXPECT_NEAR(distance.greatest_mm, 2.0 / 3, 1e-6);
}

TEST(MeshDistance, the_mesh_of_a_sphere_is_within_a_chord_of_it) {
  const Volume sphere = sphere_phantom();
  const Mesh mesh = extract_isosurface(sphere, 0.5);
  const MeshDistance distance = distance_of_mesh(sphere, 0.5, mesh);
  EXPECT_GT(distance.mean_mm, 0);
  // A side of up to sqrt(3) mm in a sphere of 16 mm leaves it by 3 / (8 * 16) mm at the most, and
  // the interpolant bulges from the sphere by as much.
  EXPECT_LT(distance.greatest_mm, 2 * 3 / (8.0 * 16));
}

}  // namespace
}  // namespace isolux
