#include "isolux/intersect/shadow_grid.h"

#include <bit>
#include <cmath>
#include <utility>

#include "isolux/base/parallel.h"

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

ShadowGrid::ShadowGrid(const std::vector<SeenPacket>& packets, const std::vector<Part>& boxes)
    : cells_(cells_for(packets.size())), half_(static_cast<float>(cells_) / 2) {
  const std::size_t count = number(0, cells_);
  first_.resize(count + 1);
  least_start_.resize(count, kInfinity);
  constexpr std::size_t kPiece = 1024;  // packets
  std::vector<std::vector<Part>> pieces((packets.size() + kPiece - 1) / kPiece);
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t piece = begin; piece < end; ++piece) {
      const std::size_t first = kPiece * piece, last = std::min(first + kPiece, packets.size());
      pieces[piece].reserve(2 * kPiece);
      for (std::size_t n = first; n < last; ++n) add_parts(packets[n], boxes[n], pieces[piece]);
    }
  });
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
void ShadowGrid::add_parts(const SeenPacket& seen, const Part& box, std::vector<Part>& to) const {
  const float together = 1 / half_;
  if (box.lanes == 0) return;
  if (box.high_x - box.low_x <= together && box.high_y - box.low_y <= together) {
    to.push_back(box);
    return;
  }
  for (std::uint32_t left = box.lanes; left != 0;) {
    const int first = std::countr_zero(left);
    Part part{box.packet};
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
