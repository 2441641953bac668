#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "isolux/base/vec3.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// The lowest voxel (i, j, k) of a cell; its corners are that voxel and the next along each axis.
using CellIndex = std::array<int, 3>;

/// Eight numbers at the corners of a cell; corner (x, y, z), each 0 or 1, is at x + 2 y + 4 z.
using CellCorners = std::array<double, 8>;

template <typename T>
CellCorners cell_corners(const VolumeView<T>& v, const CellIndex& cell) {
  const auto [i, j, k] = cell;
  return {v.value(i, j, k),         v.value(i + 1, j, k),        v.value(i, j + 1, k),
          v.value(i + 1, j + 1, k), v.value(i, j, k + 1),        v.value(i + 1, j, k + 1),
          v.value(i, j + 1, k + 1), v.value(i + 1, j + 1, k + 1)};
}

/// Between a and b, exactly a at w = 0, b at w = 1, and a everywhere if a == b.
inline double lerp_exact(double a, double b, double w) {
  return w < 0.5 ? a + w * (b - a) : b - (1 - w) * (b - a);
}

/// The trilinear interpolant at `local` in [0, 1]^3. On a face it depends on that face's corners
/// alone, to the last bit, so two cells that share a face agree on it.
inline double interpolate(const CellCorners& c, Vec3 local) {
  double z[2];
  for (std::size_t k = 0; k < 2; ++k) {
    const double low = lerp_exact(c[4 * k], c[4 * k + 1], local.x);
    const double high = lerp_exact(c[4 * k + 2], c[4 * k + 3], local.x);
    z[k] = lerp_exact(low, high, local.y);
  }
  return lerp_exact(z[0], z[1], local.z);
}

/// The interpolant's own gradient, per voxel step along each axis.
inline Vec3 interpolant_gradient(const CellCorners& c, Vec3 p) {
  const double x = p.x, y = p.y, z = p.z;
  return {(1 - z) * ((1 - y) * (c[1] - c[0]) + y * (c[3] - c[2])) +
              z * ((1 - y) * (c[5] - c[4]) + y * (c[7] - c[6])),
          (1 - z) * ((1 - x) * (c[2] - c[0]) + x * (c[3] - c[1])) +
              z * ((1 - x) * (c[6] - c[4]) + x * (c[7] - c[5])),
          (1 - y) * ((1 - x) * (c[4] - c[0]) + x * (c[5] - c[1])) +
              y * ((1 - x) * (c[6] - c[2]) + x * (c[7] - c[3]))};
}

/// Central differences at a voxel, one-sided at the border, per voxel step along each axis.
template <typename T>
Vec3 central_difference(const VolumeView<T>& v, int i, int j, int k) {
  const auto along = [](int at, int count, auto value_at) {
    const int low = at > 0 ? at - 1 : at;
    const int high = at + 1 < count ? at + 1 : at;
    return (value_at(high) - value_at(low)) / (high - low);
  };
  return {along(i, v.dims[0], [&](int at) { return v.value(at, j, k); }),
          along(j, v.dims[1], [&](int at) { return v.value(i, at, k); }),
          along(k, v.dims[2], [&](int at) { return v.value(i, j, at); })};
}

/// The contract's gradient: the trilinear blend of the central differences at the cell's corners,
/// per voxel step; corners of no weight are left out. Nothing where it vanishes or is not finite.
template <typename T>
std::optional<Vec3> blended_gradient(const VolumeView<T>& v, const CellIndex& cell, Vec3 local) {
  Vec3 gradient;
  double scale = 0;  // what the sum is made of, to tell a vanishing sum from rounding
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    const double weight =
        (x ? local.x : 1 - local.x) * (y ? local.y : 1 - local.y) * (z ? local.z : 1 - local.z);
    if (weight == 0) continue;
    const Vec3 term = weight * central_difference(v, cell[0] + x, cell[1] + y, cell[2] + z);
    gradient = gradient + term;
    scale += std::fabs(term.x) + std::fabs(term.y) + std::fabs(term.z);
  }
  constexpr double kRounding = 1e-14;
  const bool vanishes = !(length(gradient) > kRounding * scale);
  if (vanishes || !is_finite(gradient)) return std::nullopt;
  return gradient;
}

}  // namespace isolux
