#pragma once

#include <optional>

#include "isolux/base/rgb.h"
#include "isolux/base/vec3.h"

namespace isolux {

/// A light in world space.
struct Light {
  enum class Kind { kPoint, kDirectional };

  Kind kind = Kind::kDirectional;
  /// Point: where it is, in mm. Directional: a vector towards it, of any length but zero.
  Vec3 place;
  Rgb intensity{1, 1, 1};  ///< colour times intensity; may exceed 1
  /// Point lights only: intensity falls with the square of the distance and is `intensity` at this
  /// distance in mm. Nothing: the same at every distance.
  std::optional<double> inverse_square_reference_mm;

  bool operator==(const Light&) const = default;
};

}  // namespace isolux
