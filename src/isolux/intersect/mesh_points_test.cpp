#include "isolux/intersect/mesh_points.h"

#include <gtest/gtest.h>

#include <random>

#include "every_instruction_set.h"
#include "isolux/intersect/ray_triangle.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/mesh/mesh_attributes.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

TEST(MeshPoints, lanes_find_what_the_plain_code_finds_to_the_last_bit_on_every_instruction_set) {
  Mesh with_normals = extract_isosurface(head_phantom(24), 300);
  with_normals.normals[with_normals.triangles[7][0]] = {};
  Mesh with_faces = with_normals;
  with_faces.normals.clear();
  with_faces.triangles.push_back({4, 4, 5});  // without area
  for (const Mesh* mesh : {&with_normals, &with_faces}) {
    on_every_instruction_set([&](const std::string& set) {
      std::mt19937 random(3);
      const auto number = [&] { return static_cast<double>(random()) / 2147483647.5 - 1; };
      for (int packet = 0; packet < 40; ++packet) {
        RayLanes rays;
        std::uint32_t triangle[RayLanes::kCount];
        const auto count = static_cast<std::uint32_t>(mesh->triangles.size());
        for (std::uint32_t n = 0; n < RayLanes::kCount; ++n) {
          triangle[n] = packet == 0 ? count - 1 - n : static_cast<std::uint32_t>(random() % count);
          for (int axis = 0; axis < 3; ++axis) {
            rays.origin[axis][n] = 200 * number();
            rays.direction[axis][n] = n % 5 == 0 && axis != packet % 3 ? 0 : number();
          }
        }
        const std::uint32_t asked = packet % 4 == 3 ? 0x0f00f00fu : ~0u;
        MeshPointLanes points;
        find_mesh_points(*mesh, rays, triangle, asked, points);
        EXPECT_EQ((points.met | points.turned) & ~asked, 0u);
        for (std::uint32_t n = 0; n < RayLanes::kCount; ++n) {
          if (!(asked >> n & 1)) continue;
          const Ray ray{{rays.origin[0][n], rays.origin[1][n], rays.origin[2][n]},
                        {rays.direction[0][n], rays.direction[1][n], rays.direction[2][n]}};
          const auto [t, u, v] =
              RayTriangles(ray).in_plane(corners(*mesh, mesh->triangles[triangle[n]]));
          ASSERT_EQ(points.met >> n & 1, std::isfinite(t)) << set;
          if (!std::isfinite(t)) continue;
          const MeshPoint point{triangle[n], static_cast<float>(u), static_cast<float>(v)};
          const Vec3 normal = shading_normal(*mesh, point);
          EXPECT_EQ(points.t[n], t) << set;
          EXPECT_EQ(points.u[n], point.u);
          EXPECT_EQ(points.v[n], point.v);
          const bool away = dot(normal, ray.direction) > 0;
          EXPECT_EQ(points.turned >> n & 1, away);
          for (int axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(points.normal[axis][n],
                      static_cast<float>(away ? -normal[axis] : normal[axis]))
                << set;
          }
        }
      }
    });
  }
}

}  // namespace
}  // namespace isolux
