#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/intersect/raster_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <bit>
#include <limits>

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

// The corners of some triangles, one a lane.
struct Corners {
  Vec3D at[3];

  // Of triangle(n) for lane n.
  template <typename TriangleOfLane>
  HWY_INLINE Corners(const View& view, const TriangleOfLane& triangle) {
    alignas(64) std::int64_t bytes[3][kMost];
    for (std::size_t n = 0; n < hn::Lanes(kD); ++n) {
      const Mesh::Triangle& vertices = view.triangles[triangle(n)];
      for (std::size_t c = 0; c < 3; ++c) {
        bytes[c][n] = static_cast<std::int64_t>(sizeof(Projected)) * vertices[c];
      }
    }
    const double* x = &view.vertices->x;
    for (std::size_t c = 0; c < 3; ++c) {
      const VI place = hn::Load(kI, bytes[c]);
      at[c] = {hn::GatherOffset(kD, x, place), hn::GatherOffset(kD, x + 1, place),
               hn::GatherOffset(kD, x + 2, place)};
    }
  }
};

HWY_INLINE unsigned bits_of(MD mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(kD, mask, bytes);
  return bytes[0];
}

// As Projection::box, for triangles in front of the eye.
HWY_INLINE std::size_t candidates_among(const View& view, std::size_t begin, std::size_t count,
                                        Candidate* to) {
  const Corners corners(view, [=](std::size_t n) { return begin + std::min(n, count - 1); });
  const Projection& projection = *view.projection;
  const bool orthographic = projection.is_orthographic();
  const VD zero = hn::Zero(kD), one = hn::Set(kD, 1.0);
  VD low[2], high[2], least = hn::Set(kD, Projection::kFar), greatest = zero;
  for (int axis = 0; axis < 2; ++axis) {
    low[axis] = hn::Set(kD, Projection::kFar);
    high[axis] = hn::Set(kD, -Projection::kFar);
  }
  for (const Vec3D& corner : corners.at) {
    least = hn::IfThenElse(hn::Lt(corner.z, least), corner.z, least);
    greatest = hn::IfThenElse(hn::Lt(greatest, corner.z), corner.z, greatest);
    const VD scale = orthographic ? one : hn::Div(one, corner.z);
    const VD at[2] = {hn::Mul(corner.x, scale), hn::Mul(corner.y, scale)};
    for (int axis = 0; axis < 2; ++axis) {
      low[axis] = hn::IfThenElse(hn::Lt(at[axis], low[axis]), at[axis], low[axis]);
      high[axis] = hn::IfThenElse(hn::Lt(high[axis], at[axis]), at[axis], high[axis]);
    }
  }
  const VD hair = hn::Set(kD, Projection::kHair);
  const double last[2] = {projection.width() - 1.0, projection.height() - 1.0};
  MD covering = hn::Gt(greatest, zero);
  alignas(64) double from[2][kMost], until[2][kMost];
  for (int axis = 0; axis < 2; ++axis) {
    const VD first = hn::Max(zero, hn::Ceil(hn::Sub(low[axis], hair)));
    const VD end = hn::Min(hn::Set(kD, last[axis]), hn::Floor(hn::Add(high[axis], hair)));
    covering = hn::And(covering, hn::Le(first, end));
    hn::Store(first, kD, from[axis]);
    hn::Store(end, kD, until[axis]);
  }
  const unsigned asked = (1u << std::min(hn::Lanes(kD), count)) - 1;
  // Those that pass the eye are left to the plain code.
  const MD passing_eye = hn::And(hn::Gt(greatest, zero), hn::Le(least, zero));
  const unsigned passing = orthographic ? 0 : bits_of(passing_eye) & asked;
  std::size_t found = 0;
  for (unsigned rest = (bits_of(covering) & asked) | passing; rest != 0; rest &= rest - 1) {
    const int n = std::countr_zero(rest);
    const auto triangle = static_cast<std::uint32_t>(begin) + static_cast<std::uint32_t>(n);
    if (passing >> n & 1) {
      const PixelBox box = projection.box(corners_of(view, triangle));
      if (!box.is_empty()) to[found++] = candidate(triangle, box);
      continue;
    }
    to[found++] = {triangle, static_cast<std::uint16_t>(from[0][n]),
                   static_cast<std::uint16_t>(from[1][n]), static_cast<std::uint16_t>(until[0][n]),
                   static_cast<std::uint16_t>(until[1][n])};
  }
  return found;
}

std::size_t find_here(const View& view, std::size_t begin, std::size_t end, Candidate* to) {
  std::size_t found = 0;
  for (std::size_t n = begin; n < end; n += hn::Lanes(kD)) {
    found += candidates_among(view, n, end - n, to + found);
  }
  return found;
}

// A box of no more pixels along an edge is small.
constexpr int kSmall = 4;

// The functions of some triangles, one a lane, as TriangleFunctions; and what they are at the first
// pixels of the triangles' boxes.
struct Functions {
  struct Linear {
    VD x, y, constant;

    HWY_INLINE VD at(VD px, VD py) const {
      return hn::Add(hn::Add(hn::Mul(x, px), hn::Mul(y, py)), constant);
    }
  };
  unsigned has_area;
  Linear edge[3], nearness;
  VD bound[3];

  HWY_INLINE Functions(const View& view, const Corners& corners) {
    const bool orthographic = view.projection->is_orthographic();
    const VD zero = hn::Zero(kD), one = hn::Set(kD, 1.0);
    Vec3D q[3] = {corners.at[0], corners.at[1], corners.at[2]};
    if (orthographic) q[0].z = q[1].z = q[2].z = one;
    const VD area = dot(q[0], cross(q[1], q[2]));
    const VD sign = hn::IfThenElse(hn::Lt(area, zero), hn::Neg(one), one);
    const VD size = hn::Abs(area);
    const VD most = hn::Set(kD, std::numeric_limits<double>::max());
    has_area = bits_of(hn::And(hn::Gt(size, zero), hn::Le(size, most)));
    const VD per_area = hn::Div(one, size);
    nearness = {zero, zero, zero};
    for (std::size_t n = 0; n < 3; ++n) {
      const Vec3D c = cross(q[(n + 1) % 3], q[(n + 2) % 3]);
      edge[n] = {hn::Mul(sign, c.x), hn::Mul(sign, c.y), hn::Mul(sign, c.z)};
      const MD owns = hn::Or(hn::Gt(edge[n].x, zero),
                             hn::And(hn::Eq(edge[n].x, zero), hn::Gt(edge[n].y, zero)));
      bound[n] = hn::IfThenElseZero(owns, hn::Set(kD, kOwnsEdge));
      const VD share = orthographic ? hn::Mul(hn::Neg(corners.at[n].z), per_area) : per_area;
      nearness.x = hn::Add(nearness.x, hn::Mul(share, edge[n].x));
      nearness.y = hn::Add(nearness.y, hn::Mul(share, edge[n].y));
      nearness.constant = hn::Add(nearness.constant, hn::Mul(share, edge[n].constant));
    }
  }
};

// The first pixels of some triangles' boxes, one triangle a lane. Most triangles of a fine mesh
// have no others.
struct SmallBoxes {
  alignas(64) std::uint64_t covered[kMost];  ///< bit kSmall y + x
  alignas(64) double nearness[kSmall * kSmall][kMost];

  HWY_INLINE SmallBoxes(const Functions& of, const PixelBox* boxes) {
    alignas(64) double x0[kMost], y0[kMost];
    int width = 0, height = 0;
    for (std::size_t n = 0; n < hn::Lanes(kD); ++n) {
      x0[n] = boxes[n].x0;
      y0[n] = boxes[n].y0;
      if (!boxes[n].is_within(kSmall)) continue;
      width = std::max(width, boxes[n].x1 - boxes[n].x0 + 1);
      height = std::max(height, boxes[n].y1 - boxes[n].y0 + 1);
    }
    VD along_x[4][kSmall];
    for (int x = 0; x < width; ++x) {
      const VD px = hn::Add(hn::Load(kD, x0), hn::Set(kD, static_cast<double>(x)));
      for (std::size_t n = 0; n < 4; ++n) {
        along_x[n][x] = hn::Mul(n < 3 ? of.edge[n].x : of.nearness.x, px);
      }
    }
    auto bits = hn::Zero(kU);
    for (int y = 0; y < height; ++y) {
      const VD py = hn::Add(hn::Load(kD, y0), hn::Set(kD, static_cast<double>(y)));
      VD along_y[4];
      for (std::size_t n = 0; n < 4; ++n) {
        along_y[n] = hn::Mul(n < 3 ? of.edge[n].y : of.nearness.y, py);
      }
      for (int x = 0; x < width; ++x) {
        const auto value = [&](std::size_t n, VD constant) HWY_ATTR {
          return hn::Add(hn::Add(along_x[n][x], along_y[n]), constant);
        };
        const MD inside = hn::And(hn::And(hn::Gt(value(0, of.edge[0].constant), of.bound[0]),
                                          hn::Gt(value(1, of.edge[1].constant), of.bound[1])),
                                  hn::Gt(value(2, of.edge[2].constant), of.bound[2]));
        const int pixel = kSmall * y + x;
        bits = hn::Or(bits, hn::IfThenElseZero(hn::RebindMask(kU, inside),
                                               hn::Set(kU, std::uint64_t{1} << pixel)));
        hn::Store(value(3, of.nearness.constant), kD, nearness[pixel]);
      }
    }
    hn::Store(bits, kU, covered);
  }
};

// One tile being drawn.
struct Canvas {
  PixelBox area;
  double nearness_limit;
  TileBuffer& buffer;

  int place(int x, int y) const { return (y - area.y0) * TileBuffer::kRow + x - area.x0; }
};

HWY_INLINE void draw_small(const SmallBoxes& boxes, int lane, std::uint32_t triangle,
                           const PixelBox& box, const Canvas& canvas) {
  for (std::uint64_t rest = boxes.covered[lane]; rest != 0; rest &= rest - 1) {
    const int pixel = std::countr_zero(rest);
    const int x = box.x0 + pixel % kSmall, y = box.y0 + pixel / kSmall;
    if (x > box.x1 || y > box.y1) continue;
    const double nearness = boxes.nearness[pixel][lane];
    const int at = canvas.place(x, y);
    if (nearness > canvas.buffer.nearness[at] && nearness < canvas.nearness_limit) {
      canvas.buffer.nearness[at] = nearness;
      canvas.buffer.triangle[at] = triangle;
    }
  }
}

// The functions of one triangle, for all lanes.
struct Repeated {
  Functions::Linear functions[4];
  VD bound[3];

  HWY_INLINE Repeated(const Functions& of, int lane) {
    const auto repeated = [=](VD v) HWY_ATTR {
      alignas(64) double stored[kMost];
      hn::Store(v, kD, stored);
      return hn::Set(kD, stored[lane]);
    };
    for (std::size_t n = 0; n < 4; ++n) {
      const Functions::Linear& f = n < 3 ? of.edge[n] : of.nearness;
      functions[n] = {repeated(f.x), repeated(f.y), repeated(f.constant)};
      if (n < 3) bound[n] = repeated(of.bound[n]);
    }
  }
};

// A vector of pixels of a row at a time.
HWY_INLINE void draw_rows(const Repeated& of, std::uint32_t triangle, const PixelBox& box,
                          const Canvas& canvas) {
  const auto lanes = static_cast<int>(hn::Lanes(kD));
  const VD limit = hn::Set(kD, canvas.nearness_limit);
  const VD last = hn::Set(kD, static_cast<double>(box.x1));
  const auto number = hn::Set(kU, triangle);
  for (int y = box.y0; y <= box.y1; ++y) {
    const VD py = hn::Set(kD, static_cast<double>(y));
    for (int x = box.x0; x <= box.x1; x += lanes) {
      const VD px = hn::Iota(kD, static_cast<double>(x));
      MD drawn = hn::Le(px, last);
      for (std::size_t n = 0; n < 3; ++n) {
        drawn = hn::And(drawn, hn::Gt(of.functions[n].at(px, py), of.bound[n]));
      }
      if (hn::AllFalse(kD, drawn)) continue;
      const VD nearness = of.functions[3].at(px, py);
      double* nearest = canvas.buffer.nearness + canvas.place(x, y);
      std::uint64_t* nearest_triangle = canvas.buffer.triangle + canvas.place(x, y);
      const VD before = hn::LoadU(kD, nearest);
      drawn = hn::And(drawn, hn::And(hn::Gt(nearness, before), hn::Lt(nearness, limit)));
      hn::StoreU(hn::IfThenElse(drawn, nearness, before), kD, nearest);
      const auto held = hn::LoadU(kU, nearest_triangle);
      hn::StoreU(hn::IfThenElse(hn::RebindMask(kU, drawn), number, held), kU, nearest_triangle);
    }
  }
}

// The vertices of candidates that come soon, since they lie anywhere.
HWY_INLINE void fetch_ahead(const View& view, const Candidate* candidates, std::size_t begin,
                            std::size_t count) {
  const std::size_t lanes = hn::Lanes(kD);
  for (std::size_t n = begin + lanes; n < std::min(begin + 2 * lanes, count); ++n) {
    for (const std::uint32_t vertex : view.triangles[candidates[n].triangle]) {
      hwy::Prefetch(view.vertices + vertex);
    }
  }
  for (std::size_t n = begin + 2 * lanes; n < std::min(begin + 3 * lanes, count); ++n) {
    hwy::Prefetch(view.triangles + candidates[n].triangle);
  }
}

void draw_here(const View& view, const Candidate* candidates, std::size_t count,
               const PixelBox& area, TileBuffer& buffer) {
  const std::size_t lanes = hn::Lanes(kD);
  // Behind an orthographic eye's plane nearness is positive.
  const bool orthographic = view.projection->is_orthographic();
  const Canvas canvas{area, orthographic ? 0 : std::numeric_limits<double>::infinity(), buffer};
  for (std::size_t begin = 0; begin < count; begin += lanes) {
    fetch_ahead(view, candidates, begin, count);
    PixelBox boxes[kMost];
    for (std::size_t n = 0; n < lanes; ++n) {
      const Candidate& c = candidates[std::min(begin + n, count - 1)];
      boxes[n] = {std::max<int>(c.x0, area.x0), std::max<int>(c.y0, area.y0),
                  std::min<int>(c.x1, area.x1), std::min<int>(c.y1, area.y1)};
    }
    const Corners corners(
        view, [&](std::size_t n) { return candidates[std::min(begin + n, count - 1)].triangle; });
    const Functions functions(view, corners);
    const SmallBoxes small(functions, boxes);
    const unsigned asked = (1u << std::min(lanes, count - begin)) - 1;
    for (unsigned rest = functions.has_area & asked; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      const std::uint32_t triangle = candidates[begin + static_cast<std::size_t>(n)].triangle;
      if (boxes[n].is_within(kSmall)) {
        draw_small(small, n, triangle, boxes[n], canvas);
      } else {
        draw_rows(Repeated(functions, n), triangle, boxes[n], canvas);
      }
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
