#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/intersect/mesh_points.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include <limits>

#include "isolux/intersect/mesh_points.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<double, 8> kD;
constexpr hn::Rebind<float, decltype(kD)> kF;
using VD = hn::Vec<decltype(kD)>;
using MD = hn::Mask<decltype(kD)>;
constexpr std::size_t kMost = 8;  // lanes

struct Vec3D {
  VD x, y, z;
};

HWY_INLINE Vec3D operator+(const Vec3D& a, const Vec3D& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vec3D operator-(const Vec3D& a, const Vec3D& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vec3D operator*(VD s, const Vec3D& a) {
  return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
HWY_INLINE VD dot(const Vec3D& a, const Vec3D& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vec3D cross(const Vec3D& a, const Vec3D& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Vec3D if_then_else(MD mask, const Vec3D& yes, const Vec3D& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y),
          hn::IfThenElse(mask, yes.z, no.z)};
}
HWY_INLINE MD is_zero(const Vec3D& a) {
  const VD zero = hn::Zero(kD);
  return hn::And(hn::And(hn::Eq(a.x, zero), hn::Eq(a.y, zero)), hn::Eq(a.z, zero));
}
// Zero stays zero.
HWY_INLINE Vec3D normalized(const Vec3D& a) {
  const VD per_length = hn::Div(hn::Set(kD, 1.0), hn::Sqrt(dot(a, a)));
  return if_then_else(is_zero(a), a, per_length * a);
}

// What vertices carry, by corner and axis, side by side.
class Corners {
 public:
  // Of the triangles of lanes from `first` on; a lane that is not asked for gets another's.
  HWY_INLINE Corners(const Mesh& mesh, const std::vector<Vec3f>& values,
                     const std::uint32_t* triangle, std::uint32_t lanes, std::size_t first) {
    for (std::size_t n = 0; n < hn::Lanes(kD); ++n) {
      const bool is_asked = lanes >> (first + n) & 1;
      const Mesh::Triangle& t = mesh.triangles[is_asked ? triangle[first + n] : 0];
      for (std::size_t c = 0; c < 3; ++c) {
        values_[c][0][n] = values[t[c]].x;
        values_[c][1][n] = values[t[c]].y;
        values_[c][2][n] = values[t[c]].z;
      }
    }
  }
  HWY_INLINE Vec3D at(std::size_t corner) const {
    return {hn::Load(kD, values_[corner][0]), hn::Load(kD, values_[corner][1]),
            hn::Load(kD, values_[corner][2])};
  }

 private:
  alignas(64) double values_[3][3][kMost];
};

HWY_INLINE Vec3D load(const double (&from)[3][RayLanes::kCount], std::size_t first) {
  return {hn::Load(kD, from[0] + first), hn::Load(kD, from[1] + first),
          hn::Load(kD, from[2] + first)};
}

// As RayTriangles.
struct RayLane {
  Vec3D origin;
  MD along_x, along_y;  // the axis that the ray runs along most; else z
  VD shear_x, shear_y, scale;

  HWY_INLINE RayLane(const Vec3D& from, const Vec3D& d) : origin(from) {
    const VD x = hn::Abs(d.x), y = hn::Abs(d.y), z = hn::Abs(d.z);
    const MD x_over_y = hn::Gt(x, y);
    const MD z_over_both = hn::Gt(z, hn::IfThenElse(x_over_y, x, y));
    along_x = hn::AndNot(z_over_both, x_over_y);
    along_y = hn::AndNot(z_over_both, hn::Not(x_over_y));
    const Vec3D turned = this->turned(d);
    shear_x = hn::Div(turned.x, turned.z);
    shear_y = hn::Div(turned.y, turned.z);
    scale = hn::Div(hn::Set(kD, 1.0), turned.z);
  }
  // So that the ray's axis is z.
  HWY_INLINE Vec3D turned(const Vec3D& v) const {
    return if_then_else(along_x, Vec3D{v.y, v.z, v.x},
                        if_then_else(along_y, Vec3D{v.z, v.x, v.y}, v));
  }
  HWY_INLINE Vec3D sheared(const Vec3D& p) const {
    const Vec3D q = turned(p - origin);
    return {hn::Sub(q.x, hn::Mul(shear_x, q.z)), hn::Sub(q.y, hn::Mul(shear_y, q.z)), q.z};
  }
};

HWY_INLINE VD edge(const Vec3D& p, const Vec3D& q) {
  return hn::Sub(hn::Mul(q.x, p.y), hn::Mul(q.y, p.x));
}

HWY_INLINE void find_some(const Mesh& mesh, const RayLanes& rays, const std::uint32_t* triangle,
                          std::uint32_t lanes, std::size_t first, MeshPointLanes& points) {
  const Corners positions(mesh, mesh.positions, triangle, lanes, first);
  const Vec3D direction = load(rays.direction, first);
  const RayLane ray(load(rays.origin, first), direction);
  const Vec3D pa = ray.sheared(positions.at(0)), pb = ray.sheared(positions.at(1)),
              pc = ray.sheared(positions.at(2));
  const VD a = edge(pb, pc), b = edge(pc, pa), c = edge(pa, pb);
  const VD sum = hn::Add(hn::Add(a, b), c);
  const VD depth = dot({a, b, c}, {pa.z, pb.z, pc.z});
  const VD t = hn::Div(hn::Mul(depth, ray.scale), sum);
  hn::Store(t, kD, points.t + first);
  const auto u_float = hn::DemoteTo(kF, hn::Div(b, sum)),
             v_float = hn::DemoteTo(kF, hn::Div(c, sum));
  hn::Store(u_float, kF, points.u + first);
  hn::Store(v_float, kF, points.v + first);

  const Vec3D corner = positions.at(0);
  Vec3D normal = cross(positions.at(1) - corner, positions.at(2) - corner);
  if (!mesh.normals.empty()) {
    const Corners normals(mesh, mesh.normals, triangle, lanes, first);
    const VD u = hn::PromoteTo(kD, u_float), v = hn::PromoteTo(kD, v_float);
    const VD w = hn::Sub(hn::Sub(hn::Set(kD, 1.0), u), v);
    const Vec3D blended = w * normals.at(0) + u * normals.at(1) + v * normals.at(2);
    normal = if_then_else(is_zero(blended), normal, blended);
  }
  normal = normalized(normal);
  const MD away = hn::Gt(dot(normal, direction), hn::Zero(kD));
  normal = if_then_else(away, {hn::Neg(normal.x), hn::Neg(normal.y), hn::Neg(normal.z)}, normal);
  hn::Store(hn::DemoteTo(kF, normal.x), kF, points.normal[0] + first);
  hn::Store(hn::DemoteTo(kF, normal.y), kF, points.normal[1] + first);
  hn::Store(hn::DemoteTo(kF, normal.z), kF, points.normal[2] + first);

  const auto bits = [&](MD mask) HWY_ATTR {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(kD, mask, bytes);
    return std::uint32_t{bytes[0]} << first & lanes;
  };
  const VD most = hn::Set(kD, std::numeric_limits<double>::max());
  points.met |= bits(hn::Le(hn::Abs(t), most));
  points.turned |= bits(away);
}

void find_here(const Mesh& mesh, const RayLanes& rays, const std::uint32_t* triangle,
               std::uint32_t lanes, MeshPointLanes& points) {
  const std::size_t step = hn::Lanes(kD);
  for (std::size_t first = 0; first < RayLanes::kCount; first += step) {
    if ((lanes >> first & ((1u << step) - 1)) == 0) continue;
    find_some(mesh, rays, triangle, lanes, first, points);
  }
}

}  // namespace
}  // namespace isolux::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux {

HWY_EXPORT(find_here);

void find_mesh_points(const Mesh& mesh, const RayLanes& rays, const std::uint32_t* triangle,
                      std::uint32_t lanes, MeshPointLanes& points) {
  points.met = points.turned = 0;
  HWY_DYNAMIC_DISPATCH(find_here)(mesh, rays, triangle, lanes, points);
}

}  // namespace isolux
#endif
