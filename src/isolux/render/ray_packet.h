#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "isolux/base/ray.h"
#include "isolux/intersect/iso_lanes.h"
#include "isolux/mesh/mesh.h"

namespace isolux {

/// Rays side by side in world space. t counts in a direction's own length.
struct RayPacket {
  static constexpr int kCount = RayLanes::kCount;

  double origin[3][kCount];     ///< mm
  double direction[3][kCount];  ///< of any length but zero
  float begin[kCount];          ///< the piece of the ray that is looked at
  float end[kCount];            ///< may be infinite

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

  /// Whether `bit`'s lane has nothing as near as t_there.
  bool is_nearer(std::uint32_t bit, int n, double t_there) const {
    return !(hit & bit) || t_there < t[n];
  }

  /// Takes those hits that are nearer.
  void add(const HitLanes& hits, std::int32_t number) {
    if (hit == 0) return set(hits, number);
    for (std::uint32_t rest = hits.hit; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      const std::uint32_t bit = 1u << n;
      if (!is_nearer(bit, n, hits.t[n])) continue;
      hit |= bit;
      turned = (turned & ~bit) | (hits.turned & bit);
      t[n] = hits.t[n];
      surface[n] = number;
      point[n] = {};
      for (int axis = 0; axis < 3; ++axis) normal[axis][n] = hits.normal[axis][n];
    }
  }

  /// Takes all hits, where there were none.
  void set(const HitLanes& hits, std::int32_t number) {
    hit = hits.hit;
    turned = hits.turned;
    std::ranges::copy(hits.t, t);
    for (int axis = 0; axis < 3; ++axis) std::ranges::copy(hits.normal[axis], normal[axis]);
    std::ranges::fill(surface, number);
    std::ranges::fill(point, MeshPoint{});
  }

  /// Takes the hit of lane n on a mesh, whose normal is `outward`, if it is nearer.
  void add(int n, std::int32_t number, double t_there, const MeshPoint& there, Vec3 outward,
           bool away) {
    const std::uint32_t bit = 1u << n;
    if (!is_nearer(bit, n, t_there)) return;
    hit |= bit;
    turned = away ? turned | bit : turned & ~bit;
    t[n] = t_there;
    surface[n] = number;
    point[n] = there;
    for (int axis = 0; axis < 3; ++axis) {
      normal[axis][n] = static_cast<float>(away ? -outward[axis] : outward[axis]);
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
};

}  // namespace isolux
