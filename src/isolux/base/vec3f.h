#pragma once

#include "isolux/base/vec3.h"

namespace isolux {

/// A vector or a position as it is kept in bulk. All arithmetic is done on its Vec3.
struct Vec3f {
  float x = 0;
  float y = 0;
  float z = 0;

  bool operator==(const Vec3f&) const = default;
};

inline Vec3 as_double(Vec3f a) { return {a.x, a.y, a.z}; }
inline Vec3f as_float(Vec3 a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

}  // namespace isolux
