#include "isolux/mesh/extract_isosurface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "isolux/base/parallel.h"
#include "isolux/mesh/mesh_topology.h"
#include "isolux/volume/analytic_volume.h"
#include "isolux/volume/cell.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

double torus(Vec3 p) {
  const double ring = std::hypot(p.x, p.y) - 8;
  return 3 - std::hypot(ring, p.z);
}

// Random voxels, with a border below every iso value above -1.
template <typename T>
Volume random_volume(std::array<int, 3> dims, unsigned seed, T low, T high) {
  std::mt19937 random(seed);
  Volume volume;
  volume.dims = dims;
  volume.world_from_index = {{{{1, 0.1, 0}, {0, 0.5, 0.2}, {0, 0, 2}}}, {5, -3, 7}};
  std::vector<T> voxels;
  for (int k = 0; k < dims[2]; ++k) {
    for (int j = 0; j < dims[1]; ++j) {
      for (int i = 0; i < dims[0]; ++i) {
        const bool border =
            i == 0 || j == 0 || k == 0 || i == dims[0] - 1 || j == dims[1] - 1 || k == dims[2] - 1;
        const double share = static_cast<double>(random()) / 4294967295.0;
        voxels.push_back(border ? low : static_cast<T>(low + share * (high - low)));
      }
    }
  }
  volume.voxels = std::move(voxels);
  return volume;
}

// The greatest distance of the trilinear interpolant from the iso value at the mesh's vertices,
// measured through double positions.
double greatest_fault(const Mesh& mesh, const Volume& volume, double iso) {
  const Affine index_from_world = inverse(volume.world_from_index);
  return visit_voxels(volume, [&](const auto& view) {
    double greatest = 0;
    for (const Vec3f& position : mesh.positions) {
      const Vec3 index = index_from_world.point(as_double(position));
      CellIndex cell{};
      Vec3 local;
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        cell[a] = std::clamp(static_cast<int>(std::floor(index[axis])), 0, volume.dims[a] - 2);
        local[axis] = index[axis] - cell[a];
      }
      greatest = std::max(greatest, std::fabs(interpolate(cell_corners(view, cell), local) - iso));
    }
    return greatest;
  });
}

// Six times the volume within a closed mesh: positive where triangles run counter-clockwise.
double six_volumes(const Mesh& mesh) {
  double sum = 0;
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, triangle);
    sum += dot(a, cross(b, c));
  }
  return sum;
}

bool same(const Mesh& a, const Mesh& b) {
  return a.positions == b.positions && a.normals == b.normals && a.triangles == b.triangles;
}

TEST(ExtractIsosurface, a_sphere_is_watertight_of_euler_characteristic_2) {
  const Mesh mesh = extract_isosurface(sphere_phantom(), 0.5);
  const MeshTopology topology = topology_of(mesh);
  EXPECT_TRUE(topology.is_watertight());
  EXPECT_EQ(topology.euler_characteristic(), 2);
  EXPECT_EQ(topology.vertices, mesh.positions.size());
  // Radius 16 mm, voxels of 1 mm: the volume of 4/3 pi r^3 to a share of (1 / 16)^2.
  EXPECT_NEAR(six_volumes(mesh) / 6 / (4.0 / 3 * 3.14159265 * 16 * 16 * 16), 1, 1.0 / 256);
}

TEST(ExtractIsosurface, a_torus_is_watertight_of_euler_characteristic_0) {
  const MeshTopology topology =
      topology_of(extract_isosurface(sample_on_cube<float>(40, 13, torus), 0));
  EXPECT_TRUE(topology.is_watertight());
  EXPECT_EQ(topology.euler_characteristic(), 0);
}

TEST(ExtractIsosurface, any_field_that_ends_below_the_iso_value_gives_a_watertight_surface) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    // Sizes on both sides of a word's 64 bits, and every pattern of corners many times over.
    const std::array<int, 3> dims{60 + static_cast<int>(seed % 10), 9, 8};
    for (const Mesh& mesh :
         {extract_isosurface(random_volume<float>(dims, seed, 0, 1), 0.55),
          extract_isosurface(random_volume<std::uint8_t>(dims, seed, 0, 9), 5),
          extract_isosurface(random_volume<std::int16_t>(dims, seed, -9, 9), 0)}) {
      const MeshTopology topology = topology_of(mesh);
      EXPECT_GT(topology.triangles, 1000u);
      EXPECT_TRUE(topology.is_watertight()) << seed;
      EXPECT_EQ(topology.collapsed_triangles, 0u);
      EXPECT_EQ(topology.vertices, mesh.positions.size());
    }
  }
}

TEST(ExtractIsosurface, vertices_lie_on_the_interpolant) {
  const Volume random = random_volume<float>({20, 20, 20}, 7, 0, 1);
  // Positions are floats of up to 40 mm, so off by up to 2e-6 mm; slopes reach 1 / 0.5 mm, blurred
  // by the shear to at most 3 for each mm.
  EXPECT_LT(greatest_fault(extract_isosurface(random, 0.5), random, 0.5), 1e-5);
  const Volume head = head_phantom(48);
  EXPECT_LT(greatest_fault(extract_isosurface(head, 300), head, 300), 0.05);  // 2000 HU a mm
}

TEST(ExtractIsosurface, normals_point_to_lower_values_and_out_of_the_triangles) {
  for (const bool mirrored : {false, true}) {
    Volume volume = sphere_phantom();
    if (mirrored) volume.world_from_index.linear = diagonal({1, -1, 1});
    const Mesh mesh = extract_isosurface(volume, 0.5);
    const Vec3 center = volume.world_from_index.point({32, 32, 32});
    EXPECT_GT(six_volumes(mesh), 0);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const Vec3 outward = normalize(as_double(mesh.positions[v]) - center);
      EXPECT_GT(dot(as_double(mesh.normals[v]), outward), 0.999);
      EXPECT_NEAR(length(as_double(mesh.normals[v])), 1, 1e-6);
    }
    for (const Mesh::Triangle& triangle : mesh.triangles) {
      const auto [a, b, c] = corners(mesh, triangle);
      const Vec3 outward = cross(b - a, c - a);
      if (length(outward) < 1e-6) continue;
      EXPECT_GT(dot(normalize(outward), normalize(a - center)), 0.9);
    }
  }
}

TEST(ExtractIsosurface, the_normal_at_a_vertex_is_the_contracts) {
  const Volume volume = random_volume<float>({6, 5, 4}, 4, 0, 1);
  const Mesh mesh = extract_isosurface(volume, 0.6);
  const auto& voxels = std::get<Voxels<float>>(volume.voxels);
  const VolumeView<float> view{voxels.data(), volume.dims};
  // The first vertex: on the first crossed edge along i.
  const auto is_inside = [&](int i, int j, int k) { return view.value(i, j, k) >= 0.6; };
  CellIndex cell{0, 1, 1};
  while (is_inside(cell[0], 1, 1) == is_inside(cell[0] + 1, 1, 1)) ++cell[0];
  const double a = view.value(cell[0], 1, 1), b = view.value(cell[0] + 1, 1, 1);
  const Vec3 gradient = *blended_gradient(view, cell, {(0.6 - a) / (b - a), 0, 0});
  const Mat3 to_world = transpose(inverse(volume.world_from_index.linear));
  const Vec3 normal = normalize(-(to_world * gradient));
  const Vec3 position = volume.world_from_index.point({cell[0] + (0.6 - a) / (b - a), 1, 1});
  bool found = false;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (length(as_double(mesh.positions[v]) - position) > 1e-5) continue;
    found = true;
    EXPECT_LT(length(as_double(mesh.normals[v]) - normal), 1e-6);
  }
  EXPECT_TRUE(found) << "no vertex at the crossing next to voxel " << cell[0];
}

TEST(ExtractIsosurface, cells_with_a_corner_that_is_not_finite_hold_no_surface) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Volume volume = sphere_phantom(17);  // 4 mm; radius 16 mm is 4 voxels
    const Mesh whole = extract_isosurface(volume, 0.5);
    const auto& whole_voxels = std::get<Voxels<float>>(volume.voxels);
    std::vector<float> voxels(whole_voxels.begin(), whole_voxels.end());
    voxels[8 + 17 * (8 + 17 * 12)] = bad;  // the voxel (8, 8, 12), on the surface
    volume.voxels = std::move(voxels);
    const Mesh holed = extract_isosurface(volume, 0.5);
    const MeshTopology topology = topology_of(holed);
    EXPECT_LT(holed.triangles.size(), whole.triangles.size());
    EXPECT_GT(topology.border_edges, 0u);
    EXPECT_EQ(topology.crowded_edges, 0u);
    EXPECT_EQ(topology.vertices, holed.positions.size());     // none that no triangle uses
    for (const Mesh::Triangle& triangle : holed.triangles) {  // each within one cell of 4 mm
      const auto [a, b, c] = corners(holed, triangle);
      EXPECT_LT(std::max({length(a - b), length(b - c), length(c - a)}), 4 * std::sqrt(3.0));
    }
    const Vec3 bad_at = volume.world_from_index.point({8, 8, 12});
    for (const Vec3f& p : holed.positions) {
      const Vec3 d = as_double(p) - bad_at;
      EXPECT_GE(std::fmax(std::fabs(d.x), std::fmax(std::fabs(d.y), std::fabs(d.z))), 3.9999);
      EXPECT_TRUE(is_finite(as_double(p)));
    }
  }
}

TEST(ExtractIsosurface, a_surface_is_cut_by_the_border_only_there) {
  const Volume volume = sphere_phantom(33);  // to 32 mm from the centre; corners at 55 mm
  const double iso = 1 - 40.0 / 32;          // a sphere of 40 mm, cut by six planes
  const MeshTopology topology = topology_of(extract_isosurface(volume, iso));
  EXPECT_GT(topology.border_edges, 0u);
  EXPECT_EQ(topology.crowded_edges + topology.inconsistent_edges, 0u);
}

TEST(ExtractIsosurface, no_surface_gives_no_triangles) {
  EXPECT_TRUE(extract_isosurface(sphere_phantom(9), 5).triangles.empty());
  EXPECT_TRUE(extract_isosurface(sphere_phantom(9), -5).triangles.empty());
  EXPECT_TRUE(extract_isosurface(head_phantom(9), 1e9).triangles.empty());
  EXPECT_TRUE(extract_isosurface(head_phantom(9), -1e9).triangles.empty());
  Volume flat;
  flat.dims = {3, 3, 1};
  flat.voxels = std::vector<float>(9, 1);
  EXPECT_TRUE(extract_isosurface(flat, 1).triangles.empty());
}

TEST(ExtractIsosurface, the_same_mesh_for_any_number_of_threads) {
  const Volume volume = head_phantom(64);
  Mesh one, four;
  with_threads(1, [&] { one = extract_isosurface(volume, -300); });
  with_threads(4, [&] { four = extract_isosurface(volume, -300); });
  EXPECT_GT(one.triangles.size(), 10000u);
  EXPECT_TRUE(same(one, four));
}

}  // namespace
}  // namespace isolux
