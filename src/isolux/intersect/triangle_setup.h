#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "isolux/base/mat3.h"
#include "isolux/base/vec3f.h"
#include "isolux/intersect/rasteriser.h"

// What decides which pixels a triangle has. The code in lanes (raster_lanes.cpp) does the same
// arithmetic in the same order.

namespace isolux::raster {

/// A vertex as the picture sees it: its depth is z, its pixel (x / z, y / z); orthographic (x, y).
using Projected = Vec3;

struct PixelBox {
  int x0, y0, x1, y1;  ///< both included; x1 < x0 or y1 < y0: empty

  bool is_empty() const { return x1 < x0 || y1 < y0; }
  /// Whether it is no longer along an edge.
  bool is_within(int pixels) const { return x1 - x0 < pixels && y1 - y0 < pixels; }
};

/// Maps positions to pixels: the inverse of the rays.
class Projection {
 public:
  explicit Projection(const PixelRays& rays)
      : orthographic_(rays.direction.along_x == Vec3{} && rays.direction.along_y == Vec3{}),
        origin_(rays.origin.first),
        width_(rays.width),
        height_(rays.height) {
    const PixelRays::Plane& plane = orthographic_ ? rays.origin : rays.direction;
    to_pixel_ = inverse(Mat3{{plane.along_x, plane.along_y, rays.direction.first}});
  }

  Projected operator()(Vec3f position) const { return to_pixel_ * (as_double(position) - origin_); }

  /// Where a vertex in front of the eye is seen.
  std::array<double, 2> pixel(const Projected& p) const {
    const double scale = orthographic_ ? 1 : 1 / p.z;
    return {p.x * scale, p.y * scale};
  }

  /// The pixels whose centres the triangle may cover. Where it passes the eye's plane, what is in
  /// front of it counts, down to a millionth of its depth.
  PixelBox box(const std::array<Projected, 3>& corners) const {
    Bounds bounds;
    double greatest = 0, least = std::numeric_limits<double>::infinity();
    for (const Projected& corner : corners) {
      greatest = std::max(greatest, corner.z);
      least = std::min(least, corner.z);
    }
    if (!(greatest > 0)) return {0, 0, -1, -1};
    if (orthographic_ || least > 0) {
      for (const Projected& corner : corners) bounds.add(pixel(corner));
    } else {
      const double nearest = 1e-6 * greatest;
      for (std::size_t n = 0; n < 3; ++n) {
        const Vec3 p = corners[n], r = corners[(n + 1) % 3];
        if (p.z > nearest) bounds.add(pixel(p));
        if ((p.z > nearest) == (r.z > nearest)) continue;
        const Vec3 cut = p + (nearest - p.z) / (r.z - p.z) * (r - p);
        bounds.add({cut.x / nearest, cut.y / nearest});
      }
    }
    return {first_pixel(bounds.low_x), first_pixel(bounds.low_y), last_pixel(bounds.high_x, width_),
            last_pixel(bounds.high_y, height_)};
  }

  bool is_orthographic() const { return orthographic_; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// Further out no pixel is looked for; and boxes reach a hair beyond the corners, for rounding.
  static constexpr double kFar = 1e9, kHair = 1e-6;

 private:
  struct Bounds {
    double low_x = kFar, low_y = kFar, high_x = -kFar, high_y = -kFar;

    void add(std::array<double, 2> pixel) {
      const auto [x, y] = pixel;
      low_x = std::min(low_x, x);
      low_y = std::min(low_y, y);
      high_x = std::max(high_x, x);
      high_y = std::max(high_y, y);
    }
  };
  static int first_pixel(double low) {
    return static_cast<int>(std::max(0.0, std::ceil(std::min(low, kFar) - kHair)));
  }
  static int last_pixel(double high, int count) {
    return static_cast<int>(std::min(count - 1.0, std::floor(std::max(high, -kFar) + kHair)));
  }

  bool orthographic_;
  Vec3 origin_;
  Mat3 to_pixel_;
  int width_, height_;
};

/// A linear function of the pixel.
struct Linear {
  double x = 0, y = 0, constant = 0;

  double at(int px, int py) const { return (x * px + y * py) + constant; }
};

/// The greatest number below 0: a pixel on an edge of this bound is inside.
constexpr double kOwnsEdge = -std::numeric_limits<double>::denorm_min();

/// The functions that decide a triangle's pixels. Antisymmetric: with corners p and q exchanged an
/// edge's numbers change their sign and nothing else.
struct TriangleFunctions {
  std::array<Linear, 3> edges;
  std::array<double, 3> bounds;  ///< inside all edges are greater: kOwnsEdge, or 0
  Linear nearness;               ///< grows towards the eye
  bool is_empty = false;

  TriangleFunctions(const std::array<Projected, 3>& c, bool orthographic) {
    std::array<Vec3, 3> q = c;  // homogeneous
    if (orthographic) {
      for (Vec3& corner : q) corner.z = 1;
    }
    const double area = dot(q[0], cross(q[1], q[2]));
    const double sign = area < 0 ? -1 : 1;
    if (area == 0 || !std::isfinite(area)) {
      is_empty = true;
      return;
    }
    const double per_area = 1 / std::fabs(area);
    for (std::size_t n = 0; n < 3; ++n) {
      const Vec3 e = sign * cross(q[(n + 1) % 3], q[(n + 2) % 3]);
      edges[n] = {e.x, e.y, e.z};
      bounds[n] = e.x > 0 || (e.x == 0 && e.y > 0) ? kOwnsEdge : 0;
      // Perspective: the edge functions together are |area| / t. Orthographic: t is the corners'
      // depths blended by them.
      const double share = orthographic ? -c[n].z * per_area : per_area;
      nearness.x += share * e.x;
      nearness.y += share * e.y;
      nearness.constant += share * e.z;
    }
  }

  bool covers(int x, int y) const {
    for (std::size_t n = 0; n < 3; ++n) {
      if (!(edges[n].at(x, y) > bounds[n])) return false;
    }
    return true;
  }
};

}  // namespace isolux::raster
