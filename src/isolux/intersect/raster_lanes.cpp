#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/intersect/raster_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include "isolux/intersect/raster_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::raster::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<double, 8> kD;
constexpr hn::RebindToSigned<decltype(kD)> kI;
constexpr hn::RebindToUnsigned<decltype(kD)> kU;
using VD = hn::Vec<decltype(kD)>;
using VI = hn::Vec<decltype(kI)>;
using MD = hn::Mask<decltype(kD)>;
constexpr std::size_t kMost = 8;  // lanes

struct Vec3D {
  VD x, y, z;
};

HWY_INLINE Vec3D cross(const Vec3D& a, const Vec3D& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE VD dot(const Vec3D& a, const Vec3D& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

// Where the vertices of corner c of some triangles lie, as bytes from the first vertex.
class Places {
 public:
  HWY_INLINE void set(std::size_t lane, const Mesh::Triangle& triangle) {
    for (std::size_t c = 0; c < 3; ++c) {
      bytes_[c][lane] = static_cast<std::int64_t>(sizeof(Projected)) * triangle[c];
    }
  }
  // The double at `member` bytes into each vertex.
  HWY_INLINE VD gather(const View& view, std::size_t corner, std::size_t member) const {
    const auto* base =
        reinterpret_cast<const double*>(reinterpret_cast<const char*>(view.vertices) + member);
    return hn::GatherOffset(kD, base, hn::Load(kI, bytes_[corner]));
  }

 private:
  alignas(64) std::int64_t bytes_[3][kMost];
};

// As Projection::box, for triangles in front of the eye.
HWY_INLINE std::size_t boxes_of(const View& view, std::size_t begin, std::size_t count,
                                Candidate* to) {
  Places places;
  const std::size_t lanes = hn::Lanes(kD);
  for (std::size_t n = 0; n < lanes; ++n) {
    places.set(n, view.triangles[begin + std::min(n, count - 1)]);
  }
  const Projection& projection = *view.projection;
  const VD zero = hn::Zero(kD);
  VD low[2], high[2], least = hn::Set(kD, Projection::kFar), greatest = zero;
  for (int axis = 0; axis < 2; ++axis) {
    low[axis] = hn::Set(kD, Projection::kFar);
    high[axis] = hn::Set(kD, -Projection::kFar);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const VD depth = places.gather(view, c, offsetof(Projected, depth));
    least = hn::IfThenElse(hn::Lt(depth, least), depth, least);
    greatest = hn::IfThenElse(hn::Lt(greatest, depth), depth, greatest);
    const VD at[2] = {places.gather(view, c, offsetof(Projected, x)),
                      places.gather(view, c, offsetof(Projected, y))};
    for (int axis = 0; axis < 2; ++axis) {
      low[axis] = hn::IfThenElse(hn::Lt(at[axis], low[axis]), at[axis], low[axis]);
      high[axis] = hn::IfThenElse(hn::Lt(high[axis], at[axis]), at[axis], high[axis]);
    }
  }
  const VD hair = hn::Set(kD, Projection::kHair);
  const double last[2] = {projection.width() - 1.0, projection.height() - 1.0};
  MD any = hn::Gt(greatest, zero);
  alignas(64) double from[2][kMost], until[2][kMost];
  for (int axis = 0; axis < 2; ++axis) {
    const VD first = hn::Max(zero, hn::Ceil(hn::Sub(low[axis], hair)));
    const VD end = hn::Min(hn::Set(kD, last[axis]), hn::Floor(hn::Add(high[axis], hair)));
    any = hn::And(any, hn::Le(first, end));
    hn::Store(first, kD, from[axis]);
    hn::Store(end, kD, until[axis]);
  }
  // Those that pass the eye are left to the plain code.
  MD passing = hn::And(hn::Gt(greatest, zero), hn::Le(least, zero));
  if (projection.is_orthographic()) passing = hn::FirstN(kD, 0);
  alignas(64) double flags[2][kMost];
  hn::Store(hn::IfThenElseZero(any, hn::Set(kD, 1.0)), kD, flags[0]);
  hn::Store(hn::IfThenElseZero(passing, hn::Set(kD, 1.0)), kD, flags[1]);
  std::size_t found = 0;
  for (std::size_t n = 0; n < std::min(lanes, count); ++n) {
    const auto triangle = static_cast<std::uint32_t>(begin + n);
    if (flags[1][n] != 0) {
      const PixelBox box = projection.box(corners_of(view, triangle));
      if (!box.is_empty()) to[found++] = candidate(triangle, box);
    } else if (flags[0][n] != 0) {
      to[found++] = {
          triangle, static_cast<std::uint16_t>(from[0][n]), static_cast<std::uint16_t>(from[1][n]),
          static_cast<std::uint16_t>(until[0][n]), static_cast<std::uint16_t>(until[1][n])};
    }
  }
  return found;
}

std::size_t find_here(const View& view, std::size_t begin, std::size_t end, Candidate* to) {
  std::size_t found = 0;
  for (std::size_t n = begin; n < end; n += hn::Lanes(kD)) {
    found += boxes_of(view, n, end - n, to + found);
  }
  return found;
}

// The functions of some triangles, one a lane: as TriangleFunctions.
struct Functions {
  alignas(64) double edge[3][3][kMost];  ///< by edge: x, y, constant
  alignas(64) double nearness[3][kMost];
  alignas(64) double owns_zero[3][kMost];  ///< 1: yes
  alignas(64) double is_there[kMost];      ///< 0: it has no area
  alignas(64) double x[kMost], y[kMost];   ///< a pixel, and there:
  alignas(64) double covers[kMost];        ///< 1: yes
  alignas(64) double nearness_there[kMost];

  HWY_INLINE Functions(const View& view, const Places& places, const PixelBox* boxes) {
    const std::size_t lanes = hn::Lanes(kD);
    for (std::size_t n = 0; n < lanes; ++n) {
      x[n] = boxes[n].x0;
      y[n] = boxes[n].y0;
    }
    const VD px = hn::Load(kD, x), py = hn::Load(kD, y);
    const bool orthographic = view.projection->is_orthographic();
    Vec3D q[3];
    for (std::size_t c = 0; c < 3; ++c) {
      q[c] = {places.gather(view, c, offsetof(Projected, q.x)),
              places.gather(view, c, offsetof(Projected, q.y)),
              places.gather(view, c, offsetof(Projected, q.z))};
    }
    const VD zero = hn::Zero(kD), one = hn::Set(kD, 1.0);
    const VD area = dot(q[0], cross(q[1], q[2]));
    const VD sign = hn::IfThenElse(hn::Lt(area, zero), hn::Neg(one), one);
    const VD size = hn::Abs(area);
    const VD most = hn::Set(kD, std::numeric_limits<double>::max());
    const MD there = hn::And(hn::Gt(size, zero), hn::Le(size, most));
    const VD per_area = hn::Div(one, size);
    VD near[3] = {zero, zero, zero};
    MD inside = there;
    for (std::size_t n = 0; n < 3; ++n) {
      const Vec3D c = cross(q[(n + 1) % 3], q[(n + 2) % 3]);
      const VD e[3] = {hn::Mul(sign, c.x), hn::Mul(sign, c.y), hn::Mul(sign, c.z)};
      const MD owns = hn::Or(hn::Gt(e[0], zero), hn::And(hn::Eq(e[0], zero), hn::Gt(e[1], zero)));
      VD share = per_area;
      if (orthographic) {
        share = hn::Mul(hn::Neg(places.gather(view, n, offsetof(Projected, depth))), per_area);
      }
      for (std::size_t k = 0; k < 3; ++k) {
        near[k] = hn::Add(near[k], hn::Mul(share, e[k]));
        hn::Store(e[k], kD, edge[n][k]);
      }
      hn::Store(hn::IfThenElseZero(owns, one), kD, owns_zero[n]);
      const VD value = hn::Add(hn::Add(hn::Mul(e[0], px), hn::Mul(e[1], py)), e[2]);
      inside = hn::And(inside, hn::Or(hn::Gt(value, zero), hn::And(hn::Eq(value, zero), owns)));
    }
    for (std::size_t k = 0; k < 3; ++k) hn::Store(near[k], kD, nearness[k]);
    hn::Store(hn::IfThenElseZero(there, one), kD, is_there);
    hn::Store(hn::IfThenElseZero(inside, one), kD, covers);
    hn::Store(hn::Add(hn::Add(hn::Mul(near[0], px), hn::Mul(near[1], py)), near[2]), kD,
              nearness_there);
  }
};

// Draws one of them over more than one pixel, a vector of pixels of a row at a time.
HWY_INLINE void draw_rows(const Functions& of, std::size_t lane, std::uint32_t triangle,
                          const PixelBox& box, const PixelBox& area, double nearness_limit,
                          TileBuffer& buffer) {
  const auto lanes = static_cast<int>(hn::Lanes(kD));
  const VD zero = hn::Zero(kD), limit = hn::Set(kD, nearness_limit);
  VD along_x[4], along_y[4], constant[4];
  MD owns[3];
  for (std::size_t n = 0; n < 4; ++n) {
    const double* f[3];
    for (std::size_t k = 0; k < 3; ++k) f[k] = n < 3 ? of.edge[n][k] : of.nearness[k];
    along_x[n] = hn::Set(kD, f[0][lane]);
    along_y[n] = hn::Set(kD, f[1][lane]);
    constant[n] = hn::Set(kD, f[2][lane]);
    if (n < 3) owns[n] = hn::Gt(hn::Set(kD, of.owns_zero[n][lane]), zero);
  }
  const auto number = hn::Set(kU, triangle);
  for (int y = box.y0; y <= box.y1; ++y) {
    VD at_row[4];
    const VD py = hn::Set(kD, static_cast<double>(y));
    for (std::size_t n = 0; n < 4; ++n) at_row[n] = hn::Mul(along_y[n], py);
    for (int x = box.x0; x <= box.x1; x += lanes) {
      const VD px = hn::Iota(kD, static_cast<double>(x));
      MD drawn = hn::Le(px, hn::Set(kD, static_cast<double>(box.x1)));
      VD value[4];
      for (std::size_t n = 0; n < 4; ++n) {
        value[n] = hn::Add(hn::Add(hn::Mul(along_x[n], px), at_row[n]), constant[n]);
      }
      for (std::size_t n = 0; n < 3; ++n) {
        drawn = hn::And(drawn,
                        hn::Or(hn::Gt(value[n], zero), hn::And(hn::Eq(value[n], zero), owns[n])));
      }
      if (hn::AllFalse(kD, drawn)) continue;
      const int at = (y - area.y0) * TileBuffer::kRow + x - area.x0;
      const VD before = hn::LoadU(kD, buffer.nearness + at);
      drawn = hn::And(drawn, hn::And(hn::Gt(value[3], before), hn::Lt(value[3], limit)));
      hn::StoreU(hn::IfThenElse(drawn, value[3], before), kD, buffer.nearness + at);
      const auto held = hn::LoadU(kU, buffer.triangle + at);
      hn::StoreU(hn::IfThenElse(hn::RebindMask(kU, drawn), number, held), kU, buffer.triangle + at);
    }
  }
}

void draw_here(const View& view, const Candidate* candidates, std::size_t count,
               const PixelBox& area, TileBuffer& buffer) {
  const std::size_t lanes = hn::Lanes(kD);
  // Behind an orthographic eye's plane nearness is positive.
  const double limit =
      view.projection->is_orthographic() ? 0 : std::numeric_limits<double>::infinity();
  for (std::size_t begin = 0; begin < count; begin += lanes) {
    Places places;
    PixelBox boxes[kMost];
    for (std::size_t n = 0; n < lanes; ++n) {
      const Candidate& candidate = candidates[std::min(begin + n, count - 1)];
      places.set(n, view.triangles[candidate.triangle]);
      boxes[n] = {std::max<int>(candidate.x0, area.x0), std::max<int>(candidate.y0, area.y0),
                  std::min<int>(candidate.x1, area.x1), std::min<int>(candidate.y1, area.y1)};
    }
    const Functions functions(view, places, boxes);
    for (std::size_t n = 0; n < std::min(lanes, count - begin); ++n) {
      if (functions.is_there[n] == 0) continue;
      const PixelBox& box = boxes[n];
      const std::uint32_t triangle = candidates[begin + n].triangle;
      if (box.x0 != box.x1 || box.y0 != box.y1) {
        draw_rows(functions, n, triangle, box, area, limit, buffer);
        continue;
      }
      // Most triangles of a fine mesh have one pixel at the most, and it is tried already.
      const double nearness = functions.nearness_there[n];
      const int at = (box.y0 - area.y0) * TileBuffer::kRow + box.x0 - area.x0;
      if (functions.covers[n] == 0 || !(nearness > buffer.nearness[at]) || !(nearness < limit)) {
        continue;
      }
      buffer.nearness[at] = nearness;
      buffer.triangle[at] = triangle;
    }
  }
}

}  // namespace
}  // namespace isolux::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux::raster {

HWY_EXPORT(find_here);
HWY_EXPORT(draw_here);

std::size_t find_candidates(const View& view, std::size_t begin, std::size_t end, Candidate* to) {
  return HWY_DYNAMIC_DISPATCH(find_here)(view, begin, end, to);
}

void draw_candidates(const View& view, const Candidate* candidates, std::size_t count,
                     const PixelBox& area, TileBuffer& buffer) {
  HWY_DYNAMIC_DISPATCH(draw_here)(view, candidates, count, area, buffer);
}

}  // namespace isolux::raster
#endif
