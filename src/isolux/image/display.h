#pragma once

#include <array>
#include <cstdint>

#include "isolux/base/rgb.h"

namespace isolux {

/// How radiance becomes 8-bit pixels: 255 * clamp(T(exposure * I)), rounded to nearest.
struct Display {
  enum class Curve {
    kSrgb,  ///< T is the sRGB transfer function (IEC 61966-2-1)
    kRaw,   ///< T is the identity
  };
  Curve curve = Curve::kSrgb;
  double exposure = 1;

  bool operator==(const Display&) const = default;
};

/// T(value), not clamped; `value` is already exposed.
double transfer(const Display& display, double value);

/// One pixel. Exact: the same bits on every machine.
std::array<std::uint8_t, 3> displayed(const Display& display, Rgb radiance);

}  // namespace isolux
