#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/intersect/aimed_rays.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include "isolux/intersect/aimed_rays.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<double, 8> kD;
constexpr hn::Rebind<float, decltype(kD)> kF;
using VD = hn::Vec<decltype(kD)>;
using MD = hn::Mask<decltype(kD)>;

void aim_here(const RayLanes& rays, int first, std::uint32_t lanes, const MeshBall& ball,
              AimedRays& aimed) {
  const auto bits_of = [](MD mask) HWY_ATTR {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(kD, mask, bytes);
    return std::uint32_t{bytes[0]};
  };
  const VD zero = hn::Zero(kD), two = hn::Set(kD, 2.0);
  const VD reach = hn::Set(kD, ball.radius + 2 * ball.slack), slack = hn::Set(kD, ball.slack);
  const auto step = static_cast<int>(hn::Lanes(kD));
  std::uint32_t valid = 0, up[3] = {}, down[3] = {};
  for (int n = 0; n < AimedRays::kCount; n += step) {
    VD o[3], d[3];
    for (int axis = 0; axis < 3; ++axis) {
      o[axis] =
          hn::Sub(hn::Load(kD, rays.origin[axis] + first + n), hn::Set(kD, ball.center[axis]));
      d[axis] = hn::Load(kD, rays.direction[axis] + first + n);
    }
    const auto dot = [](const VD* a, const VD* b) HWY_ATTR {
      return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2]));
    };
    const VD per_square = hn::Div(hn::Set(kD, 1.0), dot(d, d)), per_length = hn::Sqrt(per_square);
    const VD nearest = hn::Neg(hn::Mul(dot(o, d), per_square));
    const VD half = hn::Mul(reach, per_length);
    const VD wanted_begin = hn::PromoteTo(kD, hn::Load(kF, rays.begin + first + n));
    const VD wanted_end = hn::PromoteTo(kD, hn::Load(kF, rays.end + first + n));
    const VD begin = hn::Max(wanted_begin, hn::Sub(nearest, half));
    const VD end = hn::Min(wanted_end, hn::Add(nearest, half));
    const VD slack_t = hn::Mul(slack, per_length);
    const VD start = hn::Sub(begin, hn::Mul(two, slack_t));
    alignas(64) double asked[8];
    for (int lane = 0; lane < step; ++lane) asked[lane] = lanes >> (n + lane) & 1;
    const MD near = hn::And(hn::Gt(hn::Load(kD, asked), zero), hn::Le(begin, end));
    valid |= bits_of(near) << n;
    const auto store = [&](VD value, float* to) HWY_ATTR {
      hn::Store(hn::DemoteTo(kF, hn::IfThenElseZero(near, value)), kF, to + n);
    };
    for (int axis = 0; axis < 3; ++axis) {
      store(hn::Add(o[axis], hn::Mul(start, d[axis])), aimed.origin[axis]);
      store(d[axis], aimed.direction[axis]);
      up[axis] |= bits_of(hn::Gt(d[axis], zero)) << n;
      down[axis] |= bits_of(hn::Lt(d[axis], zero)) << n;
    }
    store(hn::Add(hn::Sub(end, start), slack_t), aimed.until);
    hn::Store(start, kD, aimed.t_start + n);
    hn::Store(slack_t, kD, aimed.slack + n);
  }
  aimed.valid = valid;
  aimed.run_together = true;
  for (int axis = 0; axis < 3; ++axis) {
    aimed.run_together &= (up[axis] & valid) == 0 || (down[axis] & valid) == 0;
  }
}

}  // namespace
}  // namespace isolux::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux {

HWY_EXPORT(aim_here);

void aim(const RayLanes& rays, int first, std::uint32_t lanes, const MeshBall& ball,
         AimedRays& aimed) {
  HWY_DYNAMIC_DISPATCH(aim_here)(rays, first, lanes, ball, aimed);
}

}  // namespace isolux
#endif
