#pragma once

namespace isolux {

/// A linear RGB triple: a colour, an intensity or a coefficient per channel. Unclamped.
struct Rgb {
  double r = 0;
  double g = 0;
  double b = 0;

  double operator[](int channel) const { return channel == 0 ? r : channel == 1 ? g : b; }
  double& operator[](int channel) { return channel == 0 ? r : channel == 1 ? g : b; }
  bool operator==(const Rgb&) const = default;
};

inline Rgb operator+(Rgb a, Rgb b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
inline Rgb operator*(Rgb a, Rgb b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
inline Rgb operator*(double s, Rgb a) { return {s * a.r, s * a.g, s * a.b}; }

}  // namespace isolux
