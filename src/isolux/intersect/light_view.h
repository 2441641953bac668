#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "isolux/base/ray.h"
#include "isolux/intersect/aimed_rays.h"

namespace isolux {

/// What shadow rays run to: a place in mm, or, far away, a direction.
struct RayTarget {
  Vec3 place;
  bool is_direction = false;

  /// The ray from there; it ends at t = end().
  Ray ray_from(Vec3 origin) const { return {origin, is_direction ? place : place - origin}; }
  double end() const { return is_direction ? std::numeric_limits<double>::infinity() : 1; }
};

/// A mesh as its light sees it: x and y are the same all along a shadow ray, and what grows along
/// it is nearness. All of the mesh is within -1 and 1 in x and y, and in nearness too.
class LightView {
 public:
  /// Nothing where the light is in the mesh's ball, or so near that the ball fills its sight.
  static std::optional<LightView> of(const RayTarget& light, const MeshBall& ball);

  bool is_direction;
  Vec3 from;
  Vec3 right, up, axis;
  double advance;  ///< of nearness with t along a ray, if the light is a direction
};

inline std::optional<LightView> LightView::of(const RayTarget& light, const MeshBall& ball) {
  constexpr double kMostSine = 0.9;  // of half the angle that the ball fills
  const double radius = ball.radius + ball.slack;
  const Vec3 way = light.is_direction ? light.place : ball.center - light.place;
  const double distance = length(way);
  if (!(radius > 0) || !(distance > 0)) return std::nullopt;
  if (!light.is_direction && radius > kMostSine * distance) return std::nullopt;
  const Vec3 axis = way / distance;
  const Vec3 other = std::fabs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 right = normalize(cross(axis, other)), up = cross(right, axis);
  if (light.is_direction) {
    return LightView{true,        ball.center,   right / radius,
                     up / radius, axis / radius, distance / radius};
  }
  // A ray that touches the ball makes this angle with the axis; nearness is 1 at its nearest point.
  const double tangent = radius / std::sqrt(distance * distance - radius * radius);
  const double unit = 1 / (distance - radius);
  return LightView{false, light.place, (unit / tangent) * right, (unit / tangent) * up, unit * axis,
                   0};
}

}  // namespace isolux
