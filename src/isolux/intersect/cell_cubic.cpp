#include "isolux/intersect/cell_cubic.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace isolux {
namespace {

// c0 + c1 s + c2 s^2 + c3 s^3
struct Cubic {
  double c0, c1, c2, c3;

  double at(double s) const { return c0 + s * (c1 + s * (c2 + s * c3)); }
  double slope(double s) const { return c1 + s * (2 * c2 + 3 * s * c3); }
};

Cubic along_segment(const CellCorners& c, Vec3 entry, Vec3 step) {
  // The mixed differences of the interpolant, carried from the corner 000 to the entry point.
  const double xyz = c[7] - c[6] - c[5] - c[3] + c[4] + c[2] + c[1] - c[0];
  const double xy = c[3] - c[2] - c[1] + c[0] + xyz * entry.z;
  const double xz = c[5] - c[4] - c[1] + c[0] + xyz * entry.y;
  const double yz = c[6] - c[4] - c[2] + c[0] + xyz * entry.x;
  return {interpolate(c, entry), dot(interpolant_gradient(c, entry), step),
          xy * step.x * step.y + xz * step.x * step.z + yz * step.y * step.z,
          xyz * step.x * step.y * step.z};
}

// Where the slope is zero strictly inside (0, 1), in order. Returns how many.
int turning_points(const Cubic& p, std::array<double, 2>& turns) {
  const double discriminant = p.c2 * p.c2 - 3 * p.c1 * p.c3;
  if (!(discriminant > 0)) return 0;
  const double q = -(p.c2 + std::copysign(std::sqrt(discriminant), p.c2));
  int count = 0;
  for (const double s : {q / (3 * p.c3), p.c1 / q}) {
    if (s > 0 && s < 1) turns[static_cast<std::size_t>(count++)] = s;  // false for NaN too
  }
  if (count == 2 && turns[0] > turns[1]) std::swap(turns[0], turns[1]);
  return count;
}

bool opposite(double a, double b) { return (a < 0 && b > 0) || (a > 0 && b < 0); }

// The zero of `p` in [low, high], where it is monotone and changes sign.
double zero_in_bracket(const Cubic& p, double low, double value_low, double high,
                       double value_high) {
  double s = low + (high - low) * (value_low / (value_low - value_high));
  for (int step = 0; step < 100; ++step) {
    if (!(s > low && s < high)) s = low + (high - low) / 2;
    if (!(s > low && s < high)) return s;  // neighbouring doubles
    const double value = p.at(s);
    if (value == 0) return s;
    (opposite(value, value_low) ? high : low) = s;
    const double next = s - value / p.slope(s);
    if (std::fabs(next - s) < 1e-16) return std::clamp(next, low, high);
    s = next;
  }
  return s;
}

}  // namespace

std::optional<double> first_zero(const CellCorners& corners, const CellSegment& segment) {
  const Cubic p = along_segment(corners, segment.entry, segment.exit - segment.entry);
  const double at_exit = interpolate(corners, segment.exit);
  if (p.c0 == 0 && !segment.open_start) return 0.0;

  std::array<double, 2> turns;
  const int turn_count = turning_points(p, turns);
  double low = 0;
  double value_low = p.c0;
  for (int piece = 0; piece <= turn_count; ++piece) {
    const bool last = piece == turn_count;
    const double high = last ? 1.0 : turns[static_cast<std::size_t>(piece)];
    const double value_high = last ? at_exit : p.at(high);
    if (value_high == 0) return high;
    if (opposite(value_low, value_high)) {
      return zero_in_bracket(p, low, value_low, high, value_high);
    }
    low = high;
    value_low = value_high;
  }
  return std::nullopt;
}

}  // namespace isolux
