#pragma once

#include "isolux/base/mat3.h"

namespace isolux {

/// x -> linear * x + offset.
struct Affine {
  Mat3 linear;
  Vec3 offset;

  Vec3 point(Vec3 p) const { return linear * p + offset; }
  Vec3 vector(Vec3 v) const { return linear * v; }
  bool operator==(const Affine&) const = default;
};

/// The inverse map. Not finite where the linear part is singular.
inline Affine inverse(const Affine& a) {
  const Mat3 linear = inverse(a.linear);
  return {linear, -(linear * a.offset)};
}

}  // namespace isolux
