#include "isolux/intersect/shadow_raster.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "every_instruction_set.h"
#include "isolux/base/parallel.h"
#include "isolux/intersect/mesh_surface.h"
#include "isolux/intersect/ray_triangle.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

constexpr int kCount = ShadowPacket::kCount;
constexpr std::uint32_t kAll = 0xfffe;  // the first lane is nobody's

std::shared_ptr<const Mesh> head() {
  static const auto mesh = std::make_shared<const Mesh>(extract_isosurface(head_phantom(40), 300));
  return mesh;
}

std::vector<RayTarget> lights_about_the_head() {
  return {{{300, -500, 200}}, {{20, -200, 10}},  // so near that the head fills most of its sight
          {{3, 2, 1}},                           // inside
          {{1e6, -3e6, 2e6}}, {{0, 0, 1}, true}, {normalize(Vec3{-1, 2, 0.5}), true}};
}

MeshBall ball_around(const Mesh& mesh) {
  const MeshBox box = box_of(mesh);
  return {0.5 * (box.low + box.high), 0.5 * length(box.high - box.low), 0};
}

// What trying every triangle says of a packet, as the definition has it.
void expect_shadows_of_all_triangles(const Mesh& mesh, const RayTarget& light,
                                     const ShadowPacket& packet) {
  for (int n = 1; n < kCount; ++n) {
    const RayTriangles ray(
        light.ray_from({packet.origin[0][n], packet.origin[1][n], packet.origin[2][n]}));
    bool far = false, near = false;
    for (std::uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
      const auto hit = ray.hit(corners(mesh, mesh.triangles[triangle]));
      if (!hit || triangle == packet.own[n] || !(hit->t > 0) || !(hit->t < light.end())) continue;
      far |= hit->t > packet.begin[n];
      near |= hit->t < packet.begin[n];
    }
    ASSERT_EQ(packet.far >> n & 1, far) << n;
    ASSERT_EQ(packet.near >> n & 1, near && !far) << n;
  }
  ASSERT_EQ((packet.far | packet.near) & 1, 0u);
}

class ShadowRaster : public testing::Test {
 protected:
  double number() { return static_cast<double>(random_()) / 2147483647.5 - 1; }
  Vec3 anywhere(double size) { return size * Vec3{number(), number(), number()}; }
  std::size_t below(std::size_t count) { return random_() % count; }

  // From the mesh, a little off it, and anywhere; and such that a vertex is just hit.
  Vec3 origin(const Mesh& mesh, const RayTarget& light) {
    const Vec3 on = as_double(mesh.positions[below(mesh.positions.size())]);
    switch (below(5)) {
      case 0:
        return on;
      case 1:
        return on + anywhere(1e-6);
      case 2:
        return on + anywhere(1);
      case 3:
        return on - 0.5 * light.ray_from(on).direction;
      default:
        return anywhere(120);
    }
  }

  ShadowPacket packet(const Mesh& mesh, const RayTarget& light) {
    ShadowPacket made;
    made.lanes = kAll;
    for (int n = 0; n < kCount; ++n) {
      const Vec3 at = origin(mesh, light);
      for (int axis = 0; axis < 3; ++axis) made.origin[axis][n] = at[axis];
      made.begin[n] = below(2) == 0 ? 0.0f : light.is_direction ? 5.0f : 0.01f;
      made.own[n] = ShadowPacket::kNone;
    }
    return made;
  }

  // Neighbours: all near a vertex, on a plane that faces the light somehow.
  ShadowPacket patch(const Mesh& mesh, const RayTarget& light) {
    ShadowPacket made = packet(mesh, light);
    const Vec3 on = as_double(mesh.positions[below(mesh.positions.size())]);
    const Vec3 across = anywhere(1), down = anywhere(1);
    for (int n = 0; n < kCount; ++n) {
      const Vec3 at = on + 0.7 * (n % 4) * across + 0.7 * (n / 4) * down;
      for (int axis = 0; axis < 3; ++axis) made.origin[axis][n] = at[axis];
    }
    return made;
  }

  std::mt19937 random_{11};
};

TEST_F(ShadowRaster, drawn_on_any_instruction_set_are_those_of_trying_all_triangles) {
  const auto clusters = cluster_triangles(*head());
  for (const RayTarget& light : lights_about_the_head()) {
    SCOPED_TRACE(testing::Message() << light.place.x << " " << light.place.y);
    const auto view = LightView::of(light, ball_around(*head()));
    std::vector<ShadowPacket> packets;
    for (int n = 0; n < 8; ++n) {
      packets.push_back(n % 2 ? packet(*head(), light) : patch(*head(), light));
    }
    if (!view) {  // it is inside
      EXPECT_LT(length(light.place), 10);
      continue;
    }
    std::size_t hidden = 0, drawn = 0;
    on_every_instruction_set([&](const std::string& set) {
      const bool was_drawn = draw_shadows(*head(), clusters, light, *view, packets);
      EXPECT_EQ(was_drawn, set != "scalar");
      if (!was_drawn) return;
      ++drawn;
      for (ShadowPacket& one : packets) {
        expect_shadows_of_all_triangles(*head(), light, one);
        hidden += static_cast<std::size_t>(std::popcount(one.far));
        one.far = one.near = 0;
      }
    });
    EXPECT_GT(hidden, 10 * drawn);
    EXPECT_LT(hidden, 110 * drawn);
  }
}

TEST_F(ShadowRaster, traced_are_those_that_are_drawn_whatever_came_before) {
  const MeshSurface surface(head());
  for (const RayTarget& light : lights_about_the_head()) {
    std::vector<ShadowPacket> packets;
    for (std::size_t n = 0; n < head()->triangles.size() / 64; ++n) {
      packets.push_back(n % 2 ? packet(*head(), light) : patch(*head(), light));
    }
    surface.find_shadows(light, packets);  // at first they are traced
    const std::vector<ShadowPacket> traced = packets;
    with_threads(3, [&] { surface.find_shadows(light, packets); });
    for (std::size_t n = 0; n < packets.size(); ++n) {
      ASSERT_EQ(packets[n].far, traced[n].far) << n;
      ASSERT_EQ(packets[n].near, traced[n].near) << n;
    }
    surface.find_shadows(light, std::span(packets).first(1));  // too few to be drawn
    EXPECT_EQ(packets[0].far, traced[0].far);
  }
}

TEST_F(ShadowRaster, their_own_triangle_hides_nothing_from_them_and_its_neighbours_do) {
  const RayTarget light{{40, -400, 300}};
  const MeshSurface surface(head());
  std::vector<ShadowPacket> packets;
  for (std::size_t p = 0; p < head()->triangles.size() / 64; ++p) {
    ShadowPacket made = packet(*head(), light);
    for (int n = 0; n < kCount; ++n) {
      made.own[n] = static_cast<std::uint32_t>(below(head()->triangles.size()));
      const auto [a, b, c] = corners(*head(), head()->triangles[made.own[n]]);
      // On either side of it, so that half of them would meet it.
      const Vec3 at = (a + b + c) / 3.0 + (n % 2 ? 1e-3 : -1e-3) * cross(b - a, c - a);
      for (int axis = 0; axis < 3; ++axis) made.origin[axis][n] = at[axis];
    }
    packets.push_back(made);
  }
  for (int turn = 0; turn < 2; ++turn) {  // traced, and drawn
    surface.find_shadows(light, packets);
    for (std::size_t n = 0; n < 8; ++n) {
      expect_shadows_of_all_triangles(*head(), light, packets[n]);
    }
  }
}

TEST_F(ShadowRaster, triangles_that_light_sees_edge_on_or_without_area_hide_as_they_are) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {10, 0, 0}, {0, 0, 10}, {0, 0, -10}, {5, 3, 0}, {5, 3, 1e-4f}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 1}, {0, 1, 3}, {2, 3, 4}, {2, 3, 5}, {0, 4, 5}};
  const auto clusters = cluster_triangles(mesh);
  for (const RayTarget& light : {RayTarget{{100, 0, 3}}, RayTarget{{5, 0, 80}},
                                 RayTarget{{1, 0, 0}, true}, RayTarget{{0, 0, -1}, true}}) {
    std::vector<ShadowPacket> packets;
    for (int n = 0; n < 30; ++n) packets.push_back(packet(mesh, light));
    draw_shadows(mesh, clusters, light, *LightView::of(light, ball_around(mesh)), packets);
    for (const ShadowPacket& one : packets) expect_shadows_of_all_triangles(mesh, light, one);
  }
}

TEST(TriangleClusters, hold_every_triangle_once_and_the_last_again_within_their_boxes) {
  const auto clusters = cluster_triangles(*head());
  std::vector<int> seen(head()->triangles.size());
  for (const TriangleCluster& cluster : clusters) {
    for (std::size_t n = 0; n < TriangleCluster::kCount; ++n) {
      const bool is_new = n == 0 || cluster.triangle[n] != cluster.triangle[n - 1];
      seen[cluster.triangle[n]] += is_new;
      const auto points = corners(*head(), head()->triangles[cluster.triangle[n]]);
      for (std::size_t c = 0; c < 3; ++c) {
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_EQ(cluster.corner[c][axis][n], points[c][axis]);
          EXPECT_GE(points[c][axis], as_double(cluster.low)[axis]);
          EXPECT_LE(points[c][axis], as_double(cluster.high)[axis]);
        }
      }
    }
  }
  EXPECT_EQ(seen, std::vector<int>(seen.size(), 1));
  EXPECT_LE(clusters.size(), head()->triangles.size() / TriangleCluster::kCount + 1);
}

}  // namespace
}  // namespace isolux
