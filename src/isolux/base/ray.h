#pragma once

#include "isolux/base/vec3.h"

namespace isolux {

/// origin + t * direction. In world space the direction is of unit length, so t is in millimetres;
/// carried into another space by an affine map, t keeps its meaning.
struct Ray {
  Vec3 origin;
  Vec3 direction;

  Vec3 at(double t) const { return origin + t * direction; }
};

}  // namespace isolux
