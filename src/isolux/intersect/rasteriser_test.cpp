#include "isolux/intersect/rasteriser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "every_instruction_set.h"
#include "isolux/base/parallel.h"
#include "isolux/intersect/mesh_surface.h"
#include "isolux/intersect/ray_triangle.h"
#include "isolux/intersect/triangle_setup.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/mesh/mesh_topology.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

// A camera that looks along `forward` at `target` from `distance`; orthographic where `fov` is 0.
PixelRays camera(Vec3 target, Vec3 forward, double distance, double fov_slope, int size) {
  const Vec3 f = normalize(forward);
  const Vec3 right = normalize(cross(f, std::fabs(f.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{0, 1, 0}));
  const Vec3 down = cross(f, right);
  PixelRays rays{size, size, {}, {}};
  const Vec3 eye = target - distance * f;
  const double half = fov_slope > 0 ? fov_slope : 100;
  const double step = 2 * half / size;
  const PixelRays::Plane plane{-(half - step / 2) * (right + down), step * right, step * down};
  if (fov_slope > 0) {
    rays.origin.first = eye;
    rays.direction = {f + plane.first, plane.along_x, plane.along_y};
  } else {
    rays.origin = {eye + plane.first, plane.along_x, plane.along_y};
    rays.direction.first = f;
  }
  return rays;
}

// Of a square picture, row by row.
std::vector<std::uint32_t> triangles_of(const RasterBuffer& raster, int size) {
  std::vector<std::uint32_t> triangles;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) triangles.push_back(raster.triangle(x, y));
  }
  return triangles;
}

struct Agreement {
  int pixels = 0, hits = 0, other_coverage = 0, other_triangle = 0;
  double greatest_depth_fault = 0;  ///< relative, where both hit
};

Agreement compare(const MeshSurface& surface, const PixelRays& rays) {
  const RasterBuffer raster = rasterise(surface.mesh(), rays);
  Agreement result;
  for (int y = 0; y < rays.height; ++y) {
    for (int x = 0; x < rays.width; ++x) {
      const Ray ray{rays.origin.at(x, y), rays.direction.at(x, y)};
      const auto hit = surface.first_hit(ray);
      const std::uint32_t triangle = raster.triangle(x, y);
      const bool is_drawn = triangle != RasterBuffer::kNothing;
      ++result.pixels;
      result.hits += hit.has_value();
      result.other_coverage += is_drawn != hit.has_value();
      if (!is_drawn || !hit) continue;
      result.other_triangle += triangle != hit->triangle;
      const Mesh& mesh = surface.mesh();
      const double t = RayTriangles(ray).in_plane(corners(mesh, mesh.triangles[triangle])).t;
      result.greatest_depth_fault =
          std::max(result.greatest_depth_fault, std::fabs(t - hit->t) / hit->t);
    }
  }
  return result;
}

TEST(Rasteriser, it_agrees_with_rays_from_many_sides) {
  const MeshSurface surface(
      std::make_shared<const Mesh>(extract_isosurface(head_phantom(64), 300)));
  for (const Vec3 forward : {Vec3{0, 1, 0}, Vec3{1, 0, 0}, Vec3{0, 0, -1}, Vec3{1, 2, -0.5},
                             Vec3{-1, 1, 1}, Vec3{0.01, -1, 0.003}}) {
    for (const double slope : {0.27, 0.0}) {
      const Agreement a = compare(surface, camera({0, 0, 0}, forward, 500, slope, 128));
      EXPECT_GT(a.hits, 2000);
      EXPECT_LE(a.other_coverage, a.pixels / 1000);
      EXPECT_LE(a.other_triangle, a.pixels / 1000);
      EXPECT_LT(a.greatest_depth_fault, 1e-6);
    }
  }
}

TEST(Rasteriser, an_eye_inside_a_closed_mesh_sees_it_at_every_pixel) {
  const auto mesh = std::make_shared<const Mesh>(extract_isosurface(sphere_phantom(33), 0.501));
  for (const Vec3 forward : {Vec3{0, 1, 0}, Vec3{1, 0.3, 0}, Vec3{0.2, 0.5, -1}}) {
    // 1 mm from the wall, with a wide view: triangles pass the eye's plane and its sides.
    const PixelRays rays = camera(14.9 * normalize(forward), forward, 29.8, 3, 96);
    const RasterBuffer raster = rasterise(*mesh, rays);
    for (const std::uint32_t triangle : triangles_of(raster, 96)) {
      ASSERT_NE(triangle, RasterBuffer::kNothing);
    }
    EXPECT_LE(compare(MeshSurface(mesh), rays).other_triangle, 9);
  }
}

TEST(Rasteriser, an_edge_through_pixel_centres_gives_each_to_one_triangle) {
  // A square of 8 x 8 pixels, its border and its diagonal through centres: top and left are in.
  Mesh square;
  square.positions = {{2, 2, 5}, {10, 2, 5}, {10, 10, 5}, {2, 10, 5}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  PixelRays rays{16, 16, {}, {}};
  rays.origin = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  rays.direction.first = {0, 0, 1};
  const RasterBuffer raster = rasterise(square, rays);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      const bool inside = x >= 2 && x < 10 && y >= 2 && y < 10;
      EXPECT_EQ(raster.triangle(x, y) != RasterBuffer::kNothing, inside) << x << " " << y;
    }
  }
}

TEST(Rasteriser, nothing_behind_the_eye_is_drawn) {
  Mesh mesh;
  mesh.positions = {{-9, -9, -5}, {9, -9, -5}, {0, 9, -5}};
  mesh.triangles = {{0, 1, 2}};
  for (const double slope : {1.0, 0.0}) {
    for (const double side : {1.0, -1.0}) {
      const RasterBuffer raster = rasterise(mesh, camera({0, 0, 0}, {0, 0, side}, 0, slope, 17));
      const bool is_seen = raster.triangle(8, 8) != RasterBuffer::kNothing;
      EXPECT_EQ(is_seen, side < 0);
    }
  }
}

TEST(Rasteriser, the_same_bytes_for_any_number_of_threads) {
  const Mesh mesh = extract_isosurface(head_phantom(64), -300);
  const PixelRays rays = camera({0, 0, 0}, {1, 2, -0.5}, 500, 0.27, 200);
  RasterBuffer one, four;
  with_threads(1, [&] { one = rasterise(mesh, rays); });
  with_threads(4, [&] { four = rasterise(mesh, rays); });
  EXPECT_EQ(triangles_of(one, 200), triangles_of(four, 200));
}

TEST(Rasteriser, lanes_draw_what_the_plain_code_draws_on_every_instruction_set) {
  const Mesh head = extract_isosurface(head_phantom(32), 300);
  const Mesh ball = extract_isosurface(sphere_phantom(9), 0.501);  // triangles of many pixels
  for (const Vec3 forward : {Vec3{0, 1, 0}, Vec3{1, 2, -0.5}, Vec3{-0.3, 0.2, 1}}) {
    for (const double slope : {0.27, 0.0}) {
      const PixelRays afar = camera({0, 0, 0}, forward, 500, slope, 77);  // not whole tiles
      // From within: triangles pass the eye's plane, and lie behind it.
      const PixelRays near = camera({5, 3, 1}, forward, 2, slope > 0 ? 3 : 0, 77);
      for (const auto& [mesh, rays] :
           {std::pair{&head, &afar}, std::pair{&head, &near}, std::pair{&ball, &near}}) {
        const std::vector<std::uint32_t> plain = rasterise_plainly(*mesh, *rays);
        on_every_instruction_set([&](const std::string& set) {
          EXPECT_EQ(triangles_of(rasterise(*mesh, *rays), 77), plain) << set;
        });
      }
    }
  }
}

// The sign of a triangle's area in the picture tells whether it faces the eye.
TEST(Rasteriser, through_a_closed_mesh_as_many_triangles_lead_in_as_out_at_every_pixel) {
  const Mesh head = extract_isosurface(head_phantom(32), -300.5);
  ASSERT_TRUE(topology_of(head).is_watertight());
  for (const Vec3 forward : {Vec3{0, 1, 0}, Vec3{0, 0, -1}, Vec3{1, 2, -0.5}, Vec3{1, 1, 1}}) {
    for (const double slope : {0.4, 0.0}) {
      const PixelRays rays = camera({0, 0, 0}, forward, 600, slope, 64);
      const raster::Projection projection(rays);
      std::vector<int> in_minus_out(64 * 64), crossings(64 * 64);
      for (const Mesh::Triangle& t : head.triangles) {
        const std::array c{projection(head.positions[t[0]]), projection(head.positions[t[1]]),
                           projection(head.positions[t[2]])};
        const raster::TriangleFunctions functions(c, projection.is_orthographic());
        if (functions.is_empty) continue;
        std::array<Vec3, 3> q = c;
        for (Vec3& corner : q) corner.z = projection.is_orthographic() ? 1 : corner.z;
        const int way = dot(q[0], cross(q[1], q[2])) > 0 ? 1 : -1;
        const raster::PixelBox box = projection.box(c);
        for (int y = box.y0; y <= box.y1; ++y) {
          for (int x = box.x0; x <= box.x1; ++x) {
            if (!functions.covers(x, y)) continue;
            in_minus_out[static_cast<std::size_t>(64 * y + x)] += way;
            ++crossings[static_cast<std::size_t>(64 * y + x)];
          }
        }
      }
      EXPECT_EQ(std::ranges::count(in_minus_out, 0), 64 * 64);
      EXPECT_GT(std::ranges::count_if(crossings, [](int n) { return n >= 2; }), 400);
    }
  }
}

}  // namespace
}  // namespace isolux
