#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "isolux/base/ray.h"
#include "isolux/intersect/iso_lanes.h"
#include "isolux/intersect/mesh_points.h"
#include "isolux/mesh/mesh.h"

namespace isolux {

/// Rays side by side in world space. t counts in a direction's own length.
struct RayPacket : RayLanes {
  /// In the packet of a picture's 8 x 4 pixels, where lane n's pixel is: two blocks side by side.
  static constexpr int x_of(int n) { return (n & 3) + (n >> 4 << 2); }
  static constexpr int y_of(int n) { return n >> 2 & 3; }

  void set(int n, const Ray& ray) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis][n] = ray.origin[axis];
      direction[axis][n] = ray.direction[axis];
    }
  }
  Ray ray(int n) const {
    return {{origin[0][n], origin[1][n], origin[2][n]},
            {direction[0][n], direction[1][n], direction[2][n]}};
  }
};

/// What the rays of a packet meet. Where a lane has no bit in `hit`, the rest of it means nothing.
struct PacketHits {
  static constexpr int kCount = RayPacket::kCount;

  std::uint32_t hit = 0;
  std::uint32_t turned = 0;  ///< whose normal was turned round, to the side the ray came from
  double t[kCount];
  float normal[3][kCount];  ///< unit, on the side the ray came from; zero where there is none
  std::int32_t surface[kCount];
  MeshPoint point[kCount];  ///< on a mesh

  /// Takes those hits that are nearer.
  void add(const HitLanes& hits, std::int32_t number) {
    if (hit == 0) {
      set(hits, number);
      std::ranges::fill(point, MeshPoint{});
      return;
    }
    for (std::uint32_t rest = hits.hit; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      if (is_nearer(n, hits.t[n])) take(n, hits, number, {});
    }
  }
  void add(const MeshPointLanes& points, const std::uint32_t* triangle, std::int32_t number) {
    if (hit == 0) {
      set(points, number);
      for (int n = 0; n < kCount; ++n) point[n] = {triangle[n], points.u[n], points.v[n]};
      return;
    }
    for (std::uint32_t rest = points.met; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      if (!is_nearer(n, points.t[n])) continue;
      take(n, points, number, {triangle[n], points.u[n], points.v[n]});
    }
  }

  /// Where the surface has no normal, it faces the origin of the ray.
  void face(int n, Vec3 direction) {
    if (normal[0][n] != 0 || normal[1][n] != 0 || normal[2][n] != 0) return;
    const double scale = length(direction);
    for (int axis = 0; axis < 3; ++axis) {
      normal[axis][n] = static_cast<float>(-direction[axis] / scale);
    }
  }

 private:
  static std::uint32_t bits_of(const HitLanes& hits) { return hits.hit; }
  static std::uint32_t bits_of(const MeshPointLanes& points) { return points.met; }

  // All but where on a mesh, of all lanes, out of lanes of either kind.
  template <typename Lanes>
  void set(const Lanes& from, std::int32_t number) {
    hit = bits_of(from);
    turned = from.turned;
    std::ranges::copy(from.t, t);
    for (int axis = 0; axis < 3; ++axis) std::ranges::copy(from.normal[axis], normal[axis]);
    std::ranges::fill(surface, number);
  }

  bool is_nearer(int n, double t_there) const { return !(hit >> n & 1) || t_there < t[n]; }

  // What lane n meets, out of lanes of either kind.
  template <typename Lanes>
  void take(int n, const Lanes& from, std::int32_t number, const MeshPoint& there) {
    const std::uint32_t bit = 1u << n;
    hit |= bit;
    turned = (turned & ~bit) | (from.turned & bit);
    t[n] = from.t[n];
    surface[n] = number;
    point[n] = there;
    for (int axis = 0; axis < 3; ++axis) normal[axis][n] = from.normal[axis][n];
  }
};

}  // namespace isolux
