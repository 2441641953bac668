#pragma once

#include <cmath>

#include "isolux/base/exact_math.h"
#include "isolux/base/sobol.h"
#include "isolux/base/vec3.h"

namespace isolux {

/// A direction by the cosine about `normal`: a point of the unit disk, lifted onto the sphere
/// (Malley's method).
inline Vec3 cosine_direction(Vec3 normal, UnitPoint p) {
  const double radius = std::sqrt(p.u), angle = 2 * exact::kPi * p.v;
  const double x = radius * exact::cos(angle), y = radius * exact::sin(angle);
  const double z = std::sqrt(1 - p.u);
  // Any two axes across the normal (Duff et al. 2017, "Building an orthonormal basis, revisited").
  const double sign = std::copysign(1.0, normal.z);
  const double a = -1 / (sign + normal.z), b = normal.x * normal.y * a;
  const Vec3 across{1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x};
  const Vec3 along{b, sign + normal.y * normal.y * a, -normal.y};
  return x * across + y * along + z * normal;
}

/// `direction`, or where it dips below the tangent plane that `above` is the normal of, its
/// reflection there.
inline Vec3 kept_above(Vec3 direction, Vec3 above) {
  const double down = dot(direction, above);
  return down < 0 ? direction - 2 * down * above : direction;
}

}  // namespace isolux
