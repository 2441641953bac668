#include "isolux/intersect/shadow_grid.h"

#include <bit>
#include <cmath>
#include <utility>

namespace isolux::shadow_raster {
namespace {

int cells_for(std::size_t packets) {
  constexpr double kPacketsACell = 2;
  constexpr int kMost = 256;
  const double wanted = std::sqrt(static_cast<double>(packets) / kPacketsACell);
  return std::clamp(static_cast<int>(wanted), 1, kMost);
}

}  // namespace

void Part::lean(const Moments& of) {
  const double per_ray = 1.0 / std::popcount(lanes);
  const double xx = of.xx - of.x * of.x * per_ray, yy = of.yy - of.y * of.y * per_ray;
  const double xy = of.xy - of.x * of.y * per_ray;
  const double xs = of.xs - of.x * of.s * per_ray, ys = of.ys - of.y * of.s * per_ray;
  const double area = xx * yy - xy * xy;
  if (!(area > 1e-3 * xx * yy)) return;  // in a line: it stays level
  plane_x = static_cast<float>((xs * yy - ys * xy) / area);
  plane_y = static_cast<float>((ys * xx - xs * xy) / area);
}

ShadowGrid::ShadowGrid(std::size_t packets)
    : cells_(cells_for(packets)), half_(static_cast<float>(cells_) / 2) {}

void ShadowGrid::place(const std::vector<std::vector<Part>>& pieces) {
  const std::size_t count = number(0, cells_);
  first_.resize(count + 1);
  least_start_.resize(count, kInfinity);
  const auto for_each_part = [&](const auto& use) {
    for (const std::vector<Part>& piece : pieces) std::ranges::for_each(piece, use);
  };
  for_each_part([&](const Part& part) {
    const std::size_t cell = cell_of(part);
    ++first_[cell];
    least_start_[cell] = std::min(least_start_[cell], part.least_start);
  });
  std::uint32_t sum = 0;
  for (std::uint32_t& first : first_) sum += std::exchange(first, sum);
  parts_.resize(sum);
  for (auto* numbers :
       {&boxes_.low_x, &boxes_.high_x, &boxes_.low_y, &boxes_.high_y, &boxes_.least_start}) {
    numbers->resize(sum + kRays);
  }
  std::vector<std::uint32_t> next = first_;
  for_each_part([&](const Part& part) {
    const std::uint32_t n = next[cell_of(part)]++;
    parts_[n] = part;
    boxes_.low_x[n] = part.low_x;
    boxes_.high_x[n] = part.high_x;
    boxes_.low_y[n] = part.low_y;
    boxes_.high_y[n] = part.high_y;
    boxes_.least_start[n] = part.least_start;
  });
}

// Where the eye sees past an edge, neighbours lie far apart for the light: no part is larger than a
// cell.
void ShadowGrid::divide(const SeenPacket& seen, const Part& whole, std::vector<Part>& to) const {
  const float together = 1 / half_;
  if (whole.lanes == 0) return;
  if (whole.high_x - whole.low_x <= together && whole.high_y - whole.low_y <= together) {
    to.push_back(whole);
    return;
  }
  for (std::uint32_t left = whole.lanes; left != 0;) {
    const int first = std::countr_zero(left);
    Part part{whole.packet};
    for (std::uint32_t rest = left; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      const float across = seen.x[n] - seen.x[first], down = seen.y[n] - seen.y[first];
      if (std::fabs(across) <= together / 2 && std::fabs(down) <= together / 2) part.add(seen, n);
    }
    left &= ~part.lanes;
    to.push_back(part);
  }
}

bool ShadowGrid::may_hide(const Box& box) const {
  const Cells cells = cells_of(box);
  for (int y = cells.y0; y <= cells.y1; ++y) {
    for (int x = cells.x0; x <= cells.x1; ++x) {
      if (!(box.most_nearness < least_start_[number(x, y)])) return true;
    }
  }
  return false;
}

}  // namespace isolux::shadow_raster
