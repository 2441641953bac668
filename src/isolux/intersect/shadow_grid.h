#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "isolux/intersect/shadow_raster.h"

// Shadow rays as their light sees them, for draw_shadows.

namespace isolux::shadow_raster {

constexpr int kRays = ShadowPacket::kCount;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Half the last bit of the floats below 1: by no more does a place in the view differ from what it
/// rounds to.
constexpr float kUnit = 0x1p-24f;
/// More than the difference of two places can be off.
constexpr float kHair = 16 * kUnit;

/// A packet as the light sees it.
struct SeenPacket {
  alignas(64) float x[kRays], y[kRays];
  alignas(64) float start[kRays], begin[kRays];  ///< nearness at t = 0 and at the packet's begin

  SeenPacket() {}  // it is all written once
};

/// What is found by now of each packet.
struct Found {
  std::vector<std::atomic<std::uint32_t>> far, near;

  explicit Found(std::size_t packets) : far(packets), near(packets) {}
};

/// Of the view, from where a nearness ends.
struct Box {
  float low_x, low_y, high_x, high_y, most_nearness;
};

/// Sums over rays of where in the view they are and where they start (s), from any point.
struct Moments {
  double x, y, s, xx, xy, yy, xs, ys;
};

/// Those rays of a packet that lie together, and a box around them.
struct Part {
  std::uint32_t packet = 0;
  std::uint32_t lanes = 0;
  float low_x = kInfinity, low_y = kInfinity, high_x = -kInfinity, high_y = -kInfinity;
  float least_start = kInfinity;
  /// All rays start with nearness >= plane + plane_x x + plane_y y.
  float plane = -kInfinity, plane_x = 0, plane_y = 0;

  /// Slopes the plane by least squares.
  void lean(const Moments& of);
  void add(const SeenPacket& seen, int n) {
    lanes |= 1u << n;
    low_x = std::min(low_x, seen.x[n]);
    low_y = std::min(low_y, seen.y[n]);
    high_x = std::max(high_x, seen.x[n]);
    high_y = std::max(high_y, seen.y[n]);
    least_start = std::min(least_start, seen.start[n]);
  }
  float extent() const { return high_x - low_x + high_y - low_y; }
};

/// Parts of packets in the order of the cells in which their boxes begin; none is larger than a
/// cell.
class ShadowGrid {
 public:
  explicit ShadowGrid(std::size_t packets);

  /// Appends the parts of a packet. `whole`: all of its rays that the mesh may hide.
  void divide(const SeenPacket& seen, const Part& whole, std::vector<Part>& to) const;
  /// Puts them all into their cells.
  void place(const std::vector<std::vector<Part>>& pieces);

  const Part& part(std::uint32_t n) const { return parts_[n]; }

  /// The parts' boxes again, side by side. Vectors may read beyond the last.
  struct Boxes {
    std::vector<float> low_x, high_x, low_y, high_y, least_start;
  };
  const Boxes& boxes() const { return boxes_; }

  /// The cells whose parts may reach into a box: x0 to x1 of the rows y0 to y1.
  struct Cells {
    int x0, y0, x1, y1;
  };
  Cells cells_of(const Box& box) const {
    return {std::max(0, cell(box.low_x) - 1), std::max(0, cell(box.low_y) - 1), cell(box.high_x),
            cell(box.high_y)};
  }
  /// The first part of a cell, and so the end of those before it.
  std::uint32_t first_part(int x, int y) const { return first_[number(x, y)]; }

  /// Whether any part of those cells has a ray that starts behind the box's nearest point.
  bool may_hide(const Box& box) const;

 private:
  int cell(float place) const {
    const float at = (place + 1) * half_;
    return at > 0 ? std::min(static_cast<int>(at), cells_ - 1) : 0;
  }
  std::size_t number(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(cells_) +
           static_cast<std::size_t>(x);
  }
  std::size_t cell_of(const Part& part) const { return number(cell(part.low_x), cell(part.low_y)); }

  int cells_;   // along an edge
  float half_;  // as many
  std::vector<std::uint32_t> first_;
  std::vector<float> least_start_;  // of a cell's parts
  std::vector<Part> parts_;
  Boxes boxes_;
};

}  // namespace isolux::shadow_raster
