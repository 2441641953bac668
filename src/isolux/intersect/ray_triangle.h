#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "isolux/base/ray.h"

namespace isolux {

/// Where a ray meets the plane of a triangle: at t, and at the point
/// (1 - u - v) a + u b + v c.
struct TriangleHit {
  double t;
  double u;
  double v;
};

/// One ray against triangles, in doubles. After Woop, Benthin and Wald 2013, "Watertight
/// ray/triangle intersection": vertices are sheared into the ray's space, where it is the z axis,
/// so that two triangles with a common edge compute the very same numbers for it, but for the sign.
/// Differs in what happens on an edge: there the ray is taken to pass a hair beside it, always on
/// the same side (the top-left rule of rasterisers), so that through a closed surface it passes
/// as often inward as outward.
class RayTriangles {
 public:
  explicit RayTriangles(const Ray& ray) : origin_(ray.origin) {
    const Vec3 d = ray.direction;
    z_ = std::fabs(d.x) > std::fabs(d.y) ? 0 : 1;
    if (std::fabs(d.z) > std::fabs(d[z_])) z_ = 2;
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    shear_x_ = d[x_] / d[z_];
    shear_y_ = d[y_] / d[z_];
    scale_ = 1 / d[z_];
  }

  /// The hit, also with t <= 0.
  std::optional<TriangleHit> hit(const std::array<Vec3, 3>& corners) const {
    const Weights w(*this, corners);
    const bool flipped = w.sum < 0;
    if (w.sum == 0 || !owns(w.a, w.pb, w.pc, flipped) || !owns(w.b, w.pc, w.pa, flipped) ||
        !owns(w.c, w.pa, w.pb, flipped)) {
      return std::nullopt;
    }
    return in_plane(w);
  }

  /// Where the ray meets the triangle's plane, within the triangle or not. Not finite where they
  /// are parallel.
  TriangleHit in_plane(const std::array<Vec3, 3>& corners) const {
    return in_plane(Weights(*this, corners));
  }

 private:
  struct Sheared {
    double x, y, z;
  };

  // The corners, and twice the areas that the ray makes with the sides opposite to them.
  struct Weights {
    Sheared pa, pb, pc;
    double a, b, c, sum;

    Weights(const RayTriangles& ray, const std::array<Vec3, 3>& corners)
        : pa(ray.sheared(corners[0])),
          pb(ray.sheared(corners[1])),
          pc(ray.sheared(corners[2])),
          a(edge(pb, pc)),
          b(edge(pc, pa)),
          c(edge(pa, pb)),
          sum(a + b + c) {}
  };

  TriangleHit in_plane(const Weights& w) const {
    const double depth = w.a * w.pa.z + w.b * w.pb.z + w.c * w.pc.z;
    return {depth * scale_ / w.sum, w.b / w.sum, w.c / w.sum};
  }
  Sheared sheared(const Vec3& p) const {
    const Vec3 q = p - origin_;
    return {q[x_] - shear_x_ * q[z_], q[y_] - shear_y_ * q[z_], q[z_]};
  }
  static double edge(const Sheared& p, const Sheared& q) { return q.x * p.y - q.y * p.x; }
  static bool owns(double weight, const Sheared& p, const Sheared& q, bool flipped) {
    if (weight != 0) return (weight < 0) == flipped;
    // The sign that the weight has a hair to the side: along x, or along y where that does nothing.
    const double hair = q.y != p.y ? q.y - p.y : p.x - q.x;
    return hair != 0 && (hair < 0) == flipped;
  }

  Vec3 origin_;
  int x_, y_, z_;
  double shear_x_, shear_y_, scale_;
};

}  // namespace isolux
