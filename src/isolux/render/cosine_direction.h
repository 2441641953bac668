#pragma once

#include <cmath>

#include "isolux/base/exact_math.h"
#include "isolux/base/sobol.h"
#include "isolux/base/vec3.h"

namespace isolux {

/// Two unit axes across a unit normal and each other (Duff et al. 2017, "Building an orthonormal
/// basis, revisited").
struct TangentFrame {
  Vec3 across, along, normal;

  explicit TangentFrame(Vec3 of) : normal(of) {
    const double sign = std::copysign(1.0, of.z);
    const double a = -1 / (sign + of.z), b = of.x * of.y * a;
    across = {1 + sign * of.x * of.x * a, sign * b, -sign * of.x};
    along = {b, sign + of.y * of.y * a, -of.y};
  }
  Vec3 world(Vec3 local) const { return local.x * across + local.y * along + local.z * normal; }
};

/// A direction by the cosine about z: a point of the unit disk, lifted onto the sphere (Malley's
/// method).
inline Vec3 cosine_direction(UnitPoint p) {
  const double radius = std::sqrt(p.u), angle = 2 * exact::kPi * p.v;
  return {radius * exact::cos(angle), radius * exact::sin(angle), std::sqrt(1 - p.u)};
}

/// The same about `normal`.
inline Vec3 cosine_direction(Vec3 normal, UnitPoint p) {
  return TangentFrame(normal).world(cosine_direction(p));
}

/// `direction`, or where it dips below the tangent plane that `above` is the normal of, its
/// reflection there.
inline Vec3 kept_above(Vec3 direction, Vec3 above) {
  const double down = dot(direction, above);
  return down < 0 ? direction - 2 * down * above : direction;
}

}  // namespace isolux
