#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/render/fan_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include "isolux/render/fan_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kCount = RayLanes::kCount;
constexpr hn::CappedTag<double, 8> kD;
using VD = hn::Vec<decltype(kD)>;

// Where the pixels of a packet are, as summands of a plane.
struct Pixels {
  alignas(64) double x[kCount], y[kCount];

  Pixels(int x0, int y0) {
    for (int n = 0; n < kCount; ++n) {
      x[n] = x0 + RayPacket::x_of(n);
      y[n] = y0 + RayPacket::y_of(n);
    }
  }
};

HWY_INLINE void fill(const RayFan::Plane& plane, int axis, const Pixels& pixels,
                     double (&out)[kCount]) {
  const VD first = hn::Set(kD, plane.first[axis]);
  const VD along_x = hn::Set(kD, plane.along_x[axis]), along_y = hn::Set(kD, plane.along_y[axis]);
  for (std::size_t n = 0; n < kCount; n += hn::Lanes(kD)) {
    // Not fused, as RayFan::Plane::at has it.
    const VD column = hn::Add(first, hn::Mul(hn::Load(kD, pixels.x + n), along_x));
    hn::Store(hn::Add(column, hn::Mul(hn::Load(kD, pixels.y + n), along_y)), kD, out + n);
  }
}

void aim_here(const RayFan& fan, int x0, int y0, RayLanes& rays) {
  const Pixels pixels(x0, y0);
  for (int axis = 0; axis < 3; ++axis) {
    fill(fan.origin, axis, pixels, rays.origin[axis]);
    fill(fan.direction, axis, pixels, rays.direction[axis]);
  }
}

// Op for op as normalize() in base/vec3.h.
void aim_unit_here(const RayFan& fan, int x0, int y0, RayLanes& rays) {
  aim_here(fan, x0, y0, rays);
  for (std::size_t n = 0; n < kCount; n += hn::Lanes(kD)) {
    VD d[3];
    for (int axis = 0; axis < 3; ++axis) d[axis] = hn::Load(kD, rays.direction[axis] + n);
    const VD largest = hn::Max(hn::Max(hn::Abs(d[0]), hn::Abs(d[1])), hn::Abs(d[2]));
    for (VD& part : d) part = hn::Div(part, largest);
    const VD square =
        hn::Add(hn::Add(hn::Mul(d[0], d[0]), hn::Mul(d[1], d[1])), hn::Mul(d[2], d[2]));
    const VD size = hn::Sqrt(square);
    for (int axis = 0; axis < 3; ++axis) {
      hn::Store(hn::Div(d[axis], size), kD, rays.direction[axis] + n);
    }
  }
}

std::uint32_t measure_here(const RayLanes& rays, PacketHits& hits) {
  for (std::size_t n = 0; n < kCount; n += hn::Lanes(kD)) {
    const VD x = hn::Load(kD, rays.direction[0] + n), y = hn::Load(kD, rays.direction[1] + n),
             z = hn::Load(kD, rays.direction[2] + n);
    const VD square = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
    hn::StoreU(hn::Mul(hn::LoadU(kD, hits.t + n), hn::Sqrt(square)), kD, hits.t + n);
  }
  constexpr hn::CappedTag<float, 16> kF;
  std::uint32_t without = 0;
  for (std::size_t n = 0; n < kCount; n += hn::Lanes(kF)) {
    auto zero = hn::Eq(hn::LoadU(kF, hits.normal[0] + n), hn::Zero(kF));
    for (int axis = 1; axis < 3; ++axis) {
      zero = hn::And(zero, hn::Eq(hn::LoadU(kF, hits.normal[axis] + n), hn::Zero(kF)));
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(kF, zero, bits);
    without |= static_cast<std::uint32_t>(bits[0] | bits[1] << 8) << n;
  }
  return without & hits.hit;
}

}  // namespace
}  // namespace isolux::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux {

HWY_EXPORT(aim_here);
HWY_EXPORT(aim_unit_here);
HWY_EXPORT(measure_here);

void aim(const RayFan& fan, int x0, int y0, RayLanes& rays) {
  HWY_DYNAMIC_DISPATCH(aim_here)(fan, x0, y0, rays);
}

void aim_unit(const RayFan& fan, int x0, int y0, RayLanes& rays) {
  HWY_DYNAMIC_DISPATCH(aim_unit_here)(fan, x0, y0, rays);
}

std::uint32_t measure(const RayLanes& rays, PacketHits& hits) {
  return HWY_DYNAMIC_DISPATCH(measure_here)(rays, hits);
}

}  // namespace isolux
#endif
