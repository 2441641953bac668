#include "isolux/render/fan_lanes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isolux {
namespace {

constexpr RayFan kFan{{{1.5, -2.25, 1e3}, {0.1, 0.7, -1e-3}, {-0.3, 1.0 / 3, 0.9}},
                      {{0.1, -0.2, 0.97}, {1e-3, 2e-5, -1.0 / 7}, {-3e-4, 1e-3, 1e-9}}};

TEST(FanLanes, rays_are_those_of_the_fan_to_the_bit) {
  for (const auto& [x0, y0] : {std::pair{0, 0}, {8, 4}, {1016, 1020}, {-8, 33}}) {
    RayPacket rays;
    aim(kFan, x0, y0, rays);
    for (int n = 0; n < RayPacket::kCount; ++n) {
      const Ray expected = kFan.ray(x0 + RayPacket::x_of(n), y0 + RayPacket::y_of(n));
      EXPECT_EQ(rays.ray(n).origin, expected.origin);
      EXPECT_EQ(rays.ray(n).direction, expected.direction);
    }
  }
}

TEST(FanLanes, unit_directions_are_those_of_normalize_to_the_bit) {
  RayPacket rays;
  aim_unit(kFan, 640, 8, rays);
  for (int n = 0; n < RayPacket::kCount; ++n) {
    const Ray expected = kFan.ray(640 + RayPacket::x_of(n), 8 + RayPacket::y_of(n));
    EXPECT_EQ(rays.ray(n).origin, expected.origin);
    EXPECT_EQ(rays.ray(n).direction, normalize(expected.direction));
  }
}

TEST(FanLanes, t_becomes_a_distance_and_only_hits_can_lack_a_normal) {
  RayPacket rays;
  aim(kFan, 16, 8, rays);
  PacketHits hits;
  hits.hit = 0x80000301;
  for (int n = 0; n < RayPacket::kCount; ++n) {
    hits.t[n] = 1 + n;
    for (auto& axis : hits.normal) axis[n] = 0;
  }
  hits.normal[2][8] = -1e-30f;
  EXPECT_EQ(measure(rays, hits), 0x80000201);
  for (int n = 0; n < RayPacket::kCount; ++n) {
    const Vec3 d = rays.ray(n).direction;
    EXPECT_EQ(hits.t[n], (1 + n) * std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z));
  }
}

}  // namespace
}  // namespace isolux
