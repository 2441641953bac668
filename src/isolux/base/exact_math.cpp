#include "isolux/base/exact_math.h"

#include <cmath>
#include <limits>

namespace isolux::exact {
namespace {

constexpr double kLn2 = 0.69314718055994530942;

// log2 by the series of artanh: ln m = 2 artanh((m - 1) / (m + 1)), with m in [1/sqrt2, sqrt2).
double log2_positive(double x) {
  int exponent = 0;
  double m = std::frexp(x, &exponent);  // exact
  if (m < 0.70710678118654752440) {
    m *= 2;
    --exponent;
  }
  const double z = (m - 1) / (m + 1);
  const double z2 = z * z;
  double series = 0;
  for (int k = 23; k >= 1; k -= 2) series = series * z2 + 1.0 / k;
  return exponent + 2 * z * series / kLn2;
}

// 2^x by splitting off the nearest whole number and Taylor's series for the rest.
double exp2_any(double x) {
  if (x > 1025) return std::numeric_limits<double>::infinity();
  if (x < -1080) return 0;
  const double whole = std::floor(x + 0.5);
  const double y = (x - whole) * kLn2;
  double series = 1;
  for (int k = 15; k >= 1; --k) series = 1 + series * y / k;
  return std::ldexp(series, static_cast<int>(whole));  // exact but for subnormal results
}

struct SinCos {
  double sin;
  double cos;
};

// Cody-Waite reduction to [-pi/4, pi/4], then Taylor's series.
SinCos sin_cos(double x) {
  constexpr double kHalfPiHigh = 1.57079632673412561417e+00;  // 33 bits, so that n * it is exact
  constexpr double kHalfPiLow = 6.07710050650619224932e-11;
  const double n = std::floor(x / (kPi / 2) + 0.5);
  const double y = (x - n * kHalfPiHigh) - n * kHalfPiLow;
  const double y2 = y * y;
  double s = 1;
  double c = 1;
  for (int k = 20; k >= 2; k -= 2) {
    s = 1 - s * y2 / (k * (k + 1));
    c = 1 - c * y2 / (k * (k - 1));
  }
  s *= y;
  switch (static_cast<long long>(n) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace

double pow(double x, double y) {
  if (y == 0) return 1;
  if (x <= 0) return 0;
  if (x == 1 || std::isinf(x)) return x;
  return exp2_any(y * log2_positive(x));
}

double exp(double x) { return exp2_any(x / kLn2); }
double sin(double x) { return sin_cos(x).sin; }
double cos(double x) { return sin_cos(x).cos; }
double tan(double x) {
  const SinCos sc = sin_cos(x);
  return sc.sin / sc.cos;
}

}  // namespace isolux::exact
