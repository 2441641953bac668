#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/intersect/shadow_raster.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>

#include "isolux/base/parallel.h"
#include "isolux/intersect/lane_vectors-inl.h"
#include "isolux/intersect/ray_triangle.h"
#include "isolux/intersect/shadow_grid.h"
#include "isolux/intersect/shadow_raster.h"

#ifndef ISOLUX_INTERSECT_SHADOW_RASTER_ONCE_
#define ISOLUX_INTERSECT_SHADOW_RASTER_ONCE_
namespace isolux {
namespace shadow_raster {

constexpr std::size_t kTriangles = TriangleCluster::kCount;

// Triangles as the light sees them, run counter-clockwise: relative to corner 0, and functions of
// where in the view.
struct SeenTriangles {
  alignas(64) float x[kTriangles], y[kTriangles], nearness[kTriangles];    // of corner 0
  alignas(64) float x1[kTriangles], y1[kTriangles];                        // corner 1 - corner 0
  alignas(64) float x2[kTriangles], y2[kTriangles];                        // corner 2 - corner 0
  alignas(64) float nearness1[kTriangles], nearness2[kTriangles];          // in the same way
  alignas(64) float area[kTriangles], edge_error[kTriangles];              // twice the area
  alignas(64) float along_x[kTriangles], along_y[kTriangles];              // of nearness
  alignas(64) float nearness_error[kTriangles], error_growth[kTriangles];  // with the distance
  alignas(64) float low_x[kTriangles], low_y[kTriangles], high_x[kTriangles], high_y[kTriangles];
  alignas(64) float most_nearness[kTriangles];
};

// All that drawing needs.
struct Drawing {
  const Mesh& mesh;
  const std::vector<TriangleCluster>& clusters;
  const RayTarget& light;
  const LightView& view;
  const ShadowGrid& grid;
  std::span<const ShadowPacket> packets;
  const std::vector<SeenPacket>& seen;
  Found& found;
};

// Tries the lanes of `asked` in doubles, and keeps what is near. @returns those hidden from afar.
std::uint32_t meet_exactly(const Drawing& drawing, std::uint32_t packet, std::uint32_t asked,
                           std::uint32_t triangle);

}  // namespace shadow_raster
}  // namespace isolux
#endif

HWY_BEFORE_NAMESPACE();
namespace isolux::shadow_raster::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

bool draw_all(const Mesh&, const std::vector<TriangleCluster>&, const RayTarget&, const LightView&,
              std::span<ShadowPacket>) {
  return false;
}

#else

namespace hn = hwy::HWY_NAMESPACE;
using isolux::lanes::HWY_NAMESPACE::bits_of;
using isolux::lanes::HWY_NAMESPACE::kD;
using isolux::lanes::HWY_NAMESPACE::kF;
using isolux::lanes::HWY_NAMESPACE::kHalfF;
using isolux::lanes::HWY_NAMESPACE::mask_of;
using isolux::lanes::HWY_NAMESPACE::MF;
using isolux::lanes::HWY_NAMESPACE::to_floats;
using isolux::lanes::HWY_NAMESPACE::VD;
using isolux::lanes::HWY_NAMESPACE::VF;

constexpr hn::RebindToUnsigned<decltype(kF)> kU;

// Places in the view, of points in lanes.
struct Seen {
  VD x, y, nearness;

  HWY_INLINE Seen(const LightView& view, VD px, VD py, VD pz) {
    const VD q[3] = {hn::Sub(px, hn::Set(kD, view.from.x)), hn::Sub(py, hn::Set(kD, view.from.y)),
                     hn::Sub(pz, hn::Set(kD, view.from.z))};
    const auto along = [&](Vec3 v) HWY_ATTR {
      return hn::MulAdd(q[2], hn::Set(kD, v.z),
                        hn::MulAdd(q[1], hn::Set(kD, v.y), hn::Mul(q[0], hn::Set(kD, v.x))));
    };
    x = along(view.right);
    y = along(view.up);
    nearness = along(view.axis);
    if (view.is_direction) return;
    // What is behind the light is nowhere in the view.
    nearness = hn::Div(hn::Set(kD, 1.0), hn::Max(nearness, hn::Zero(kD)));
    x = hn::Mul(x, nearness);
    y = hn::Mul(y, nearness);
  }
};

HWY_INLINE float least_of(VF v) { return hn::GetLane(hn::MinOfLanes(kF, v)); }
HWY_INLINE float most_of(VF v) { return hn::GetLane(hn::MaxOfLanes(kF, v)); }

struct SeenFloats {
  VF x, y, nearness;
};

HWY_INLINE SeenFloats in_floats(const Seen& low, const Seen& high) {
  return {to_floats({low.x, high.x}), to_floats({low.y, high.y}),
          to_floats({low.nearness, high.nearness})};
}

// The plane that fits best where the rays start, let down until none starts before it.
HWY_INLINE void find_plane(const SeenPacket& seen, Part& part) {
  const VF x0 = hn::Set(kF, part.low_x), y0 = hn::Set(kF, part.low_y),
           start0 = hn::Set(kF, part.least_start);
  VF x = hn::Zero(kF), y = x, s = x, xx = x, xy = x, yy = x, xs = x, ys = x;
  const auto relative = [&](const float* to, VF from, std::size_t lane, MF used) HWY_ATTR {
    return hn::IfThenElseZero(used, hn::Sub(hn::Load(kF, to + lane), from));
  };
  for (std::size_t lane = 0; lane < kRays; lane += hn::Lanes(kF)) {
    const MF used = mask_of(part.lanes >> lane);
    const VF dx = relative(seen.x, x0, lane, used), dy = relative(seen.y, y0, lane, used),
             ds = relative(seen.start, start0, lane, used);
    x = hn::Add(x, dx);
    y = hn::Add(y, dy);
    s = hn::Add(s, ds);
    xx = hn::MulAdd(dx, dx, xx);
    xy = hn::MulAdd(dx, dy, xy);
    yy = hn::MulAdd(dy, dy, yy);
    xs = hn::MulAdd(dx, ds, xs);
    ys = hn::MulAdd(dy, ds, ys);
  }
  const auto sum = [](VF v) HWY_ATTR { return hn::GetLane(hn::SumOfLanes(kF, v)); };
  part.lean(Moments{sum(x), sum(y), sum(s), sum(xx), sum(xy), sum(yy), sum(xs), sum(ys)});
  VF least = hn::Set(kF, kInfinity);
  const VF slope_x = hn::Set(kF, part.plane_x), slope_y = hn::Set(kF, part.plane_y);
  for (std::size_t lane = 0; lane < kRays; lane += hn::Lanes(kF)) {
    const VF height = hn::NegMulAdd(
        slope_x, hn::Load(kF, seen.x + lane),
        hn::NegMulAdd(slope_y, hn::Load(kF, seen.y + lane), hn::Load(kF, seen.start + lane)));
    least = hn::IfThenElse(mask_of(part.lanes >> lane), hn::Min(least, height), least);
  }
  // A hair for what these floats lose, and those of the triangles that are compared.
  part.plane =
      least_of(least) - 2 * kHair * (1 + std::fabs(part.plane_x) + std::fabs(part.plane_y));
  // A ray may start all but in the light.
  if (!std::isfinite(part.plane)) {
    part.plane = -kInfinity;
    part.plane_x = part.plane_y = 0;
  }
}

// Sees a packet; returns all its rays that the mesh may hide.
HWY_INLINE Part see(const LightView& view, const ShadowPacket& of, std::size_t n, SeenPacket& to) {
  const std::size_t half = hn::Lanes(kD);
  const VF edge = hn::Set(kF, 1 + kHair);
  std::uint32_t lanes_inside = 0;
  VF low_x = hn::Set(kF, kInfinity), low_y = low_x, least = low_x;
  VF high_x = hn::Neg(low_x), high_y = high_x;
  for (std::size_t lane = 0; lane < kRays; lane += hn::Lanes(kF)) {
    const auto half_at = [&](std::size_t at) HWY_ATTR {
      return Seen(view, hn::Load(kD, of.origin[0] + at), hn::Load(kD, of.origin[1] + at),
                  hn::Load(kD, of.origin[2] + at));
    };
    const SeenFloats at = in_floats(half_at(lane), half_at(lane + half));
    const VF t_begin = hn::Load(kF, of.begin + lane);
    const VF at_begin =
        view.is_direction
            ? hn::MulAdd(t_begin, hn::Set(kF, static_cast<float>(view.advance)), at.nearness)
            : hn::Div(at.nearness, hn::Max(hn::Sub(hn::Set(kF, 1.0f), t_begin), hn::Zero(kF)));
    hn::Store(at.x, kF, to.x + lane);
    hn::Store(at.y, kF, to.y + lane);
    hn::Store(at.nearness, kF, to.start + lane);
    hn::Store(at_begin, kF, to.begin + lane);
    const MF used = mask_of(of.lanes >> lane);
    const MF inside =
        hn::And(used, hn::And(hn::Le(hn::Abs(at.x), edge), hn::Le(hn::Abs(at.y), edge)));
    lanes_inside |= bits_of(inside) << lane;
    low_x = hn::IfThenElse(inside, hn::Min(low_x, at.x), low_x);
    low_y = hn::IfThenElse(inside, hn::Min(low_y, at.y), low_y);
    high_x = hn::IfThenElse(inside, hn::Max(high_x, at.x), high_x);
    high_y = hn::IfThenElse(inside, hn::Max(high_y, at.y), high_y);
    least = hn::IfThenElse(inside, hn::Min(least, at.nearness), least);
  }
  return {static_cast<std::uint32_t>(n),
          lanes_inside,
          least_of(low_x),
          least_of(low_y),
          most_of(high_x),
          most_of(high_y),
          least_of(least)};
}

// Bounds of errors: with u = kUnit, S the extent of a triangle and Q the distance of a point from
// its corner 0 (sums of |x| and |y|), coordinates are off by u, differences of corners by 4 u,
// those of points by 4 u + u Q. So the function of an edge is off by less than 18 u S + 4 u Q, the
// area by 22 u S, and the third edge, area less the two others, by 74 u S + 8 u Q. Nearness is off
// by its gradient's error times Q, and by what the gradient makes of an error in x and y.
constexpr float kEdgeErrorOfExtent = 96 * kUnit, kEdgeErrorOfDistance = 12 * kUnit;
constexpr float kAreaError = 256 * kUnit;

HWY_INLINE void see_triangles(const LightView& view, const TriangleCluster& of, SeenTriangles& to) {
  const std::size_t half = hn::Lanes(kD);
  const VF zero = hn::Zero(kF), unit = hn::Set(kF, kUnit);
  for (std::size_t n = 0; n < kTriangles; n += hn::Lanes(kF)) {
    const auto half_at = [&](std::size_t corner, std::size_t at) HWY_ATTR {
      const auto load = [&](std::size_t axis) HWY_ATTR {
        return hn::PromoteTo(kD, hn::Load(kHalfF, of.corner[corner][axis] + at));
      };
      return Seen(view, load(0), load(1), load(2));
    };
    const auto corner = [&](std::size_t c)
                            HWY_ATTR { return in_floats(half_at(c, n), half_at(c, n + half)); };
    const SeenFloats a = corner(0), b = corner(1), c = corner(2);
    VF x1 = hn::Sub(b.x, a.x), y1 = hn::Sub(b.y, a.y), n1 = hn::Sub(b.nearness, a.nearness);
    VF x2 = hn::Sub(c.x, a.x), y2 = hn::Sub(c.y, a.y), n2 = hn::Sub(c.nearness, a.nearness);
    VF area = hn::Sub(hn::Mul(x1, y2), hn::Mul(y1, x2));
    const MF clockwise = hn::Lt(area, zero);
    const auto exchange = [&](VF& one, VF& other) HWY_ATTR {
      const VF before = one;
      one = hn::IfThenElse(clockwise, other, one);
      other = hn::IfThenElse(clockwise, before, other);
    };
    exchange(x1, x2);
    exchange(y1, y2);
    exchange(n1, n2);
    area = hn::Abs(area);
    const VF extent = hn::Add(hn::Add(hn::Abs(x1), hn::Abs(y1)), hn::Add(hn::Abs(x2), hn::Abs(y2)));
    const VF per_area = hn::Div(hn::Set(kF, 1.0f), area);
    const VF along_x = hn::Mul(hn::Sub(hn::Mul(n1, y2), hn::Mul(n2, y1)), per_area);
    const VF along_y = hn::Mul(hn::Sub(hn::Mul(x1, n2), hn::Mul(x2, n1)), per_area);
    const VF steep = hn::Max(hn::Abs(along_x), hn::Abs(along_y));
    // u ((16 S_n + 64 S + 96 G S) Q / area + 16 G Q) + u (32 G + 16)
    const VF growth = hn::MulAdd(
        hn::Mul(hn::MulAdd(hn::Set(kF, 96.0f), steep, hn::Set(kF, 64.0f)), extent), per_area,
        hn::MulAdd(hn::Mul(hn::Set(kF, 16.0f), hn::Add(hn::Abs(n1), hn::Abs(n2))), per_area,
                   hn::Mul(hn::Set(kF, 16.0f), steep)));
    const VF error = hn::MulAdd(hn::Set(kF, 32.0f), steep, hn::Set(kF, 16.0f));
    const MF has_area = hn::Gt(area, hn::Mul(hn::Set(kF, kAreaError), extent));
    const VF infinity = hn::Set(kF, kInfinity);
    hn::Store(a.x, kF, to.x + n);
    hn::Store(a.y, kF, to.y + n);
    hn::Store(a.nearness, kF, to.nearness + n);
    hn::Store(n1, kF, to.nearness1 + n);
    hn::Store(n2, kF, to.nearness2 + n);
    hn::Store(x1, kF, to.x1 + n);
    hn::Store(y1, kF, to.y1 + n);
    hn::Store(x2, kF, to.x2 + n);
    hn::Store(y2, kF, to.y2 + n);
    hn::Store(area, kF, to.area + n);
    // Points in a box that the triangle's reaches are no further off than both extents.
    hn::Store(hn::Mul(hn::Set(kF, kEdgeErrorOfExtent + kEdgeErrorOfDistance), extent), kF,
              to.edge_error + n);
    hn::Store(hn::IfThenElseZero(has_area, along_x), kF, to.along_x + n);
    hn::Store(hn::IfThenElseZero(has_area, along_y), kF, to.along_y + n);
    hn::Store(hn::IfThenElse(has_area, hn::Mul(unit, error), infinity), kF, to.nearness_error + n);
    hn::Store(hn::IfThenElseZero(has_area, hn::Mul(unit, growth)), kF, to.error_growth + n);
    const VF hair = hn::Set(kF, kHair);
    const auto least = [&](VF p, VF q, VF r) HWY_ATTR { return hn::Min(p, hn::Min(q, r)); };
    const auto most = [&](VF p, VF q, VF r) HWY_ATTR { return hn::Max(p, hn::Max(q, r)); };
    hn::Store(hn::Sub(least(a.x, b.x, c.x), hair), kF, to.low_x + n);
    hn::Store(hn::Sub(least(a.y, b.y, c.y), hair), kF, to.low_y + n);
    hn::Store(hn::Add(most(a.x, b.x, c.x), hair), kF, to.high_x + n);
    hn::Store(hn::Add(most(a.y, b.y, c.y), hair), kF, to.high_y + n);
    hn::Store(hn::Add(most(a.nearness, b.nearness, c.nearness), hair), kF, to.most_nearness + n);
  }
}

HWY_INLINE Box box_of(const SeenTriangles& of) {
  VF low_x = hn::Load(kF, of.low_x), low_y = hn::Load(kF, of.low_y);
  VF high_x = hn::Load(kF, of.high_x), high_y = hn::Load(kF, of.high_y);
  VF most = hn::Load(kF, of.most_nearness);
  for (std::size_t n = hn::Lanes(kF); n < kTriangles; n += hn::Lanes(kF)) {
    low_x = hn::Min(low_x, hn::Load(kF, of.low_x + n));
    low_y = hn::Min(low_y, hn::Load(kF, of.low_y + n));
    high_x = hn::Max(high_x, hn::Load(kF, of.high_x + n));
    high_y = hn::Max(high_y, hn::Load(kF, of.high_y + n));
    most = hn::Max(most, hn::Load(kF, of.most_nearness + n));
  }
  return {least_of(low_x), least_of(low_y), most_of(high_x), most_of(high_y), most_of(most)};
}

// Which triangles may lie before a part of a packet, by their boxes.
HWY_INLINE std::uint32_t triangles_before(const SeenTriangles& of, const Part& part) {
  const auto all = [](float value) HWY_ATTR { return hn::Set(kF, value); };
  std::uint32_t found = 0;
  for (std::size_t n = 0; n < kTriangles; n += hn::Lanes(kF)) {
    const MF across = hn::And(hn::Le(hn::Load(kF, of.low_x + n), all(part.high_x)),
                              hn::Ge(hn::Load(kF, of.high_x + n), all(part.low_x)));
    const MF down = hn::And(hn::Le(hn::Load(kF, of.low_y + n), all(part.high_y)),
                            hn::Ge(hn::Load(kF, of.high_y + n), all(part.low_y)));
    const MF before = hn::Ge(hn::Load(kF, of.most_nearness + n), all(part.least_start));
    const MF boxed = hn::And(hn::And(across, down), before);
    if (hn::AllFalse(kF, boxed)) continue;
    // How far the corners are in front of the plane behind which the rays start.
    const VF slope_x = all(part.plane_x), slope_y = all(part.plane_y);
    const auto rise = [&](const float* x, const float* y, const float* nearness) HWY_ATTR {
      return hn::NegMulAdd(slope_x, hn::Load(kF, x + n),
                           hn::NegMulAdd(slope_y, hn::Load(kF, y + n), hn::Load(kF, nearness + n)));
    };
    const VF rise0 = rise(of.x, of.y, of.nearness), rise1 = rise(of.x1, of.y1, of.nearness1),
             rise2 = rise(of.x2, of.y2, of.nearness2);
    const VF most = hn::Add(rise0, hn::Max(hn::Zero(kF), hn::Max(rise1, rise2)));
    found |= bits_of(hn::And(boxed, hn::Ge(most, all(part.plane)))) << n;
  }
  return found;
}

// Draws triangles onto those rays of a part, from one lane on, that nothing is known to hide.
HWY_INLINE void draw_onto(const Drawing& drawing, const SeenTriangles& of,
                          const TriangleCluster& cluster, std::uint32_t triangles, const Part& part,
                          std::size_t lane) {
  const SeenPacket& seen = drawing.seen[part.packet];
  std::atomic<std::uint32_t>& far = drawing.found.far[part.packet];
  const std::uint32_t asked = (part.lanes & ~far.load(std::memory_order_relaxed)) >> lane;
  std::uint32_t hidden = 0;
  const VF ray_x = hn::Load(kF, seen.x + lane), ray_y = hn::Load(kF, seen.y + lane);
  const std::uint32_t* own = drawing.packets[part.packet].own;
  const VF error_of_part = hn::Set(kF, kEdgeErrorOfDistance * part.extent());
  MF open = mask_of(asked);
  const auto all = [](float value) HWY_ATTR { return hn::Set(kF, value); };
  for (; triangles != 0 && !hn::AllFalse(kF, open); triangles &= triangles - 1) {
    const auto n = static_cast<std::size_t>(std::countr_zero(triangles));
    const VF x = hn::Sub(ray_x, all(of.x[n])), y = hn::Sub(ray_y, all(of.y[n]));
    const VF edge1 = hn::NegMulAdd(all(of.y1[n]), x, hn::Mul(all(of.x1[n]), y));
    const VF edge2 = hn::NegMulAdd(all(of.x2[n]), y, hn::Mul(all(of.y2[n]), x));
    const VF edge3 = hn::Sub(all(of.area[n]), hn::Add(edge1, edge2));
    const VF inside = hn::Min(edge1, hn::Min(edge2, edge3));
    const VF error = hn::Add(error_of_part, all(of.edge_error[n]));
    MF met = hn::And(open, hn::Ge(inside, hn::Neg(error)));
    if (hn::AllFalse(kF, met)) continue;
    const auto of_others = hn::Ne(hn::Load(kU, own + lane), hn::Set(kU, cluster.triangle[n]));
    met = hn::And(met, hn::RebindMask(kF, of_others));
    const VF distance = hn::Add(hn::Abs(x), hn::Abs(y));
    const VF nearness =
        hn::MulAdd(all(of.along_x[n]), x, hn::MulAdd(all(of.along_y[n]), y, all(of.nearness[n])));
    const VF off = hn::MulAdd(all(of.error_growth[n]), distance, all(of.nearness_error[n]));
    const MF in_front =
        hn::And(met, hn::Ge(hn::Add(nearness, off), hn::Load(kF, seen.start + lane)));
    if (hn::AllFalse(kF, in_front)) continue;
    const MF surely = hn::And(hn::Gt(inside, error),
                              hn::Gt(hn::Sub(nearness, off), hn::Load(kF, seen.begin + lane)));
    std::uint32_t found = bits_of(hn::And(in_front, surely));
    const std::uint32_t doubtful = bits_of(in_front) & ~found;
    if (doubtful != 0) {
      found |= meet_exactly(drawing, part.packet, doubtful << lane, cluster.triangle[n]) >> lane;
    }
    hidden |= found;
    open = hn::AndNot(mask_of(found), open);
  }
  if (hidden != 0) far.fetch_or(hidden << lane, std::memory_order_relaxed);
}

// The parts of packets that lie in a box and may have something of it before them.
HWY_INLINE void find_parts(const Drawing& drawing, const Box& box,
                           std::vector<std::uint32_t>& found) {
  const ShadowGrid& grid = drawing.grid;
  found.clear();
  const ShadowGrid::Boxes& boxes = grid.boxes();
  const VF low_x = hn::Set(kF, box.low_x), high_x = hn::Set(kF, box.high_x);
  const VF low_y = hn::Set(kF, box.low_y), high_y = hn::Set(kF, box.high_y);
  const VF most = hn::Set(kF, box.most_nearness);
  const auto load = [](const std::vector<float>& from, std::uint32_t at)
                        HWY_ATTR { return hn::LoadU(kF, from.data() + at); };
  const ShadowGrid::Cells cells = grid.cells_of(box);
  for (int y = cells.y0; y <= cells.y1; ++y) {
    const std::uint32_t end = grid.first_part(cells.x1 + 1, y);
    for (std::uint32_t e = grid.first_part(cells.x0, y); e < end;
         e += static_cast<std::uint32_t>(hn::Lanes(kF))) {
      const MF across =
          hn::And(hn::Le(load(boxes.low_x, e), high_x), hn::Ge(load(boxes.high_x, e), low_x));
      const MF down =
          hn::And(hn::Le(load(boxes.low_y, e), high_y), hn::Ge(load(boxes.high_y, e), low_y));
      const MF before = hn::Le(load(boxes.least_start, e), most);
      std::uint32_t met = bits_of(hn::And(hn::And(across, down), before));
      if (end - e < 32) met &= (1u << (end - e)) - 1;
      for (; met != 0; met &= met - 1) {
        const std::uint32_t n = e + static_cast<std::uint32_t>(std::countr_zero(met));
        const Part& part = grid.part(n);
        const std::uint32_t far = drawing.found.far[part.packet].load(std::memory_order_relaxed);
        if ((part.lanes & ~far) != 0) found.push_back(n);
      }
    }
  }
}

// Around a cluster: its box's corners, whose places bound all between them.
HWY_INLINE Box box_around(const LightView& view, const TriangleCluster& cluster) {
  alignas(64) static constexpr double kUpper[3][8] = {
      {0, 1, 0, 1, 0, 1, 0, 1}, {0, 0, 1, 1, 0, 0, 1, 1}, {0, 0, 0, 0, 1, 1, 1, 1}};
  const Vec3 low = as_double(cluster.low), size = as_double(cluster.high) - low;
  VD low_x = hn::Set(kD, double{kInfinity}), low_y = low_x;
  VD high_x = hn::Neg(low_x), high_y = high_x, most = high_x;
  for (std::size_t n = 0; n < 8; n += hn::Lanes(kD)) {
    const auto at = [&](int axis) HWY_ATTR {
      return hn::MulAdd(hn::Load(kD, kUpper[axis] + n), hn::Set(kD, size[axis]),
                        hn::Set(kD, low[axis]));
    };
    const Seen corner(view, at(0), at(1), at(2));
    low_x = hn::Min(low_x, corner.x);
    low_y = hn::Min(low_y, corner.y);
    high_x = hn::Max(high_x, corner.x);
    high_y = hn::Max(high_y, corner.y);
    most = hn::Max(most, corner.nearness);
  }
  const auto least = [](VD v) HWY_ATTR {
    return static_cast<float>(hn::GetLane(hn::MinOfLanes(kD, v))) - kHair;
  };
  const auto greatest = [](VD v) HWY_ATTR {
    return static_cast<float>(hn::GetLane(hn::MaxOfLanes(kD, v))) + kHair;
  };
  return {least(low_x), least(low_y), greatest(high_x), greatest(high_y), greatest(most)};
}

void draw(const Drawing& drawing, std::size_t begin, std::size_t end) {
  SeenTriangles of;
  std::vector<std::uint32_t> parts;
  for (std::size_t c = begin; c < end; ++c) {
    const TriangleCluster& cluster = drawing.clusters[c];
    if (!drawing.grid.may_hide(box_around(drawing.view, cluster))) continue;
    see_triangles(drawing.view, cluster, of);
    find_parts(drawing, box_of(of), parts);  // in a smaller box
    for (const std::uint32_t n : parts) {
      const Part& part = drawing.grid.part(n);
      const std::uint32_t before = triangles_before(of, part);
      if (before == 0) continue;
      for (std::size_t lane = 0; lane < kRays; lane += hn::Lanes(kF)) {
        draw_onto(drawing, of, cluster, before, part, lane);
      }
    }
  }
}

bool draw_all(const Mesh& mesh, const std::vector<TriangleCluster>& clusters,
              const RayTarget& light, const LightView& view, std::span<ShadowPacket> packets) {
  std::vector<SeenPacket> seen(packets.size());
  ShadowGrid grid(packets.size());
  constexpr std::size_t kPiece = 256;
  std::vector<std::vector<Part> > pieces((packets.size() + kPiece - 1) / kPiece);
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t piece = begin; piece < end; ++piece) {
      std::vector<Part>& parts = pieces[piece];
      parts.reserve(2 * kPiece);
      const std::size_t first = kPiece * piece, last = std::min(first + kPiece, packets.size());
      for (std::size_t n = first; n < last; ++n) {
        grid.divide(seen[n], see(view, packets[n], n, seen[n]), parts);
      }
      for (Part& part : parts) find_plane(seen[part.packet], part);
    }
  });
  grid.place(pieces);
  Found found(packets.size());
  const Drawing drawing{mesh, clusters, light, view, grid, packets, seen, found};
  parallel_for(clusters.size(), 128,
               [&](std::size_t begin, std::size_t end) { draw(drawing, begin, end); });
  for (std::size_t n = 0; n < packets.size(); ++n) {
    packets[n].far = found.far[n];
    packets[n].near = found.near[n] & ~found.far[n];
  }
  return true;
}

#endif

}  // namespace
}  // namespace isolux::shadow_raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux {
namespace shadow_raster {

std::uint32_t meet_exactly(const Drawing& drawing, std::uint32_t packet, std::uint32_t asked,
                           std::uint32_t triangle) {
  const ShadowPacket& rays = drawing.packets[packet];
  const auto points = corners(drawing.mesh, drawing.mesh.triangles[triangle]);
  std::uint32_t far = 0, near = 0;
  for (; asked != 0; asked &= asked - 1) {
    const int n = std::countr_zero(asked);
    const Vec3 origin{rays.origin[0][n], rays.origin[1][n], rays.origin[2][n]};
    const auto there = RayTriangles(drawing.light.ray_from(origin)).hit(points);
    if (!there || !(there->t > 0) || !(there->t < drawing.light.end())) continue;
    if (there->t > rays.begin[n]) far |= 1u << n;
    if (there->t < rays.begin[n]) near |= 1u << n;
  }
  if (near != 0) drawing.found.near[packet].fetch_or(near, std::memory_order_relaxed);
  return far;
}

HWY_EXPORT(draw_all);

}  // namespace shadow_raster

bool draw_shadows(const Mesh& mesh, const std::vector<TriangleCluster>& clusters,
                  const RayTarget& light, const LightView& view, std::span<ShadowPacket> packets) {
  using namespace shadow_raster;
  return HWY_DYNAMIC_DISPATCH(draw_all)(mesh, clusters, light, view, packets);
}

}  // namespace isolux
#endif
