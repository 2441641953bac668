#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/render/light_spread_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "isolux/render/light_spread.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

void spread(const SpreadBlock& block, const SurfaceBuffer& buffer, const RayFan& fan,
            bool is_orthographic, std::span<float* const> to) {
  spread_light_plainly(block, buffer, fan, is_orthographic, to);
}

#else

constexpr hn::CappedTag<float, SurfaceBuffer::kBlockPixels> kF;
constexpr hn::RebindToSigned<decltype(kF)> kI;
using VF = hn::Vec<decltype(kF)>;

struct Vector {
  VF x, y, z;
};

HWY_INLINE VF all(double value) { return hn::Set(kF, static_cast<float>(value)); }
HWY_INLINE VF square(VF a) { return hn::Mul(a, a); }
HWY_INLINE VF dot(const Vector& a, const Vector& b) {
  return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}
HWY_INLINE Vector all(Vec3f v) { return {all(v.x), all(v.y), all(v.z)}; }
// (1 - a)^2 where a < 1.
HWY_INLINE VF falling(VF a) { return square(hn::Max(hn::Zero(kF), hn::Sub(all(1), a))); }

HWY_INLINE Vector plane_at(const RayFan::Plane& plane, VF x, VF y) {
  const auto one = [&](auto axis) HWY_ATTR {
    return hn::MulAdd(y, all(plane.along_y.*axis),
                      hn::MulAdd(x, all(plane.along_x.*axis), all(plane.first.*axis)));
  };
  return {one(&Vec3::x), one(&Vec3::y), one(&Vec3::z)};
}

void spread(const SpreadBlock& block, const SurfaceBuffer& buffer, const RayFan& fan,
            bool is_orthographic, std::span<float* const> to) {
  for (std::size_t first = 0; first < SurfaceBuffer::kBlockPixels; first += hn::Lanes(kF)) {
    const std::size_t place = block.place + first;
    const auto lane = hn::Iota(kI, static_cast<std::int32_t>(first));
    const VF x = hn::Add(all(block.x), hn::ConvertTo(kF, hn::And(lane, hn::Set(kI, 3))));
    const VF y = hn::Add(all(block.y), hn::ConvertTo(kF, hn::ShiftRight<2>(lane)));
    float depths[SurfaceBuffer::kBlockPixels];
    for (std::size_t n = 0; n < hn::Lanes(kF); ++n) {
      depths[n] = static_cast<float>(buffer.depth_mm[place + n]);
    }
    const Vector along = plane_at(fan.direction, x, y);
    const VF far = hn::Div(hn::LoadU(kF, depths), hn::Sqrt(dot(along, along)));
    const Vector origin = is_orthographic ? plane_at(fan.origin, x, y) : all(Vec3f{});
    const Vector position{hn::MulAdd(along.x, far, origin.x), hn::MulAdd(along.y, far, origin.y),
                          hn::MulAdd(along.z, far, origin.z)};
    const Vector normal{hn::LoadU(kF, &buffer.normal_x[place]),
                        hn::LoadU(kF, &buffer.normal_y[place]),
                        hn::LoadU(kF, &buffer.normal_z[place])};
    const auto surface = hn::LoadU(kI, &buffer.surface[place]);
    VF weights = hn::Zero(kF), sums[3] = {weights, weights, weights};
    for (int n = 0; n < block.count; ++n) {
      const LightSpread::Point& point = *block.points[n];
      const Vector from = all(point.position), its = all(point.normal);
      const VF off = dot(its, {hn::Sub(position.x, from.x), hn::Sub(position.y, from.y),
                               hn::Sub(position.z, from.z)});
      const VF apart = hn::MulAdd(hn::Sub(x, all(point.x)), hn::Sub(x, all(point.x)),
                                  square(hn::Sub(y, all(point.y))));
      const VF likeness = hn::Max(hn::Zero(kF), dot(its, normal));
      VF weight = hn::Mul(hn::Mul(falling(hn::Mul(all(kSpreadScale), apart)),
                                  falling(hn::Mul(all(point.plane_scale), square(off)))),
                          square(square(square(likeness))));
      weight = hn::IfThenElseZero(hn::RebindMask(kF, hn::Eq(surface, hn::Set(kI, point.surface))),
                                  weight);
      if (n == 0) weight = hn::Max(weight, all(kLeastSpread));
      weights = hn::Add(weights, weight);
      for (std::size_t c = 0; c < to.size(); ++c) {
        const auto& [mean, slope] = block.lights[n][c];
        const VF light = hn::MulAdd(
            normal.z, all(slope[2]),
            hn::MulAdd(normal.y, all(slope[1]), hn::MulAdd(normal.x, all(slope[0]), all(mean))));
        sums[c] = hn::MulAdd(weight, light, sums[c]);
      }
    }
    const VF scale = hn::Div(all(1), weights);
    for (std::size_t c = 0; c < to.size(); ++c) {
      hn::StoreU(hn::Max(hn::Zero(kF), hn::Mul(sums[c], scale)), kF, to[c] + place);
    }
  }
}

#endif

}  // namespace
}  // namespace isolux::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux {

HWY_EXPORT(spread);

void spread_light(const SpreadBlock& block, const SurfaceBuffer& buffer, const RayFan& fan,
                  bool is_orthographic, std::span<float* const> to) {
  HWY_DYNAMIC_DISPATCH(spread)(block, buffer, fan, is_orthographic, to);
}

void spread_light_plainly(const SpreadBlock& block, const SurfaceBuffer& buffer, const RayFan& fan,
                          bool is_orthographic, std::span<float* const> to) {
  const auto falling = [](double a) {
    const double rest = std::max(0.0, 1 - a);
    return rest * rest;
  };
  for (std::size_t n = 0; n < SurfaceBuffer::kBlockPixels; ++n) {
    const std::size_t place = block.place + n;
    const double x = block.x + static_cast<double>(n % 4), y = block.y + static_cast<double>(n / 4);
    const Vec3 origin = is_orthographic ? fan.origin.at(x, y) : Vec3{};
    const Vec3 position = origin + buffer.depth_mm[place] * normalize(fan.direction.at(x, y));
    const Vec3 normal{buffer.normal_x[place], buffer.normal_y[place], buffer.normal_z[place]};
    double weights = 0;
    Vec3 sums;
    for (int p = 0; p < block.count; ++p) {
      const LightSpread::Point& point = *block.points[p];
      const double dx = x - point.x, dy = y - point.y;
      const double off = dot(as_double(point.normal), position - as_double(point.position));
      const double likeness = std::max(0.0, dot(as_double(point.normal), normal));
      double weight = falling(kSpreadScale * (dx * dx + dy * dy)) *
                      falling(point.plane_scale * off * off) * std::pow(likeness, 8);
      if (buffer.surface[place] != point.surface) weight = 0;
      if (p == 0) weight = std::max<double>(weight, kLeastSpread);
      weights += weight;
      for (std::size_t c = 0; c < to.size(); ++c) {
        const auto& [mean, slope] = block.lights[p][c];
        sums[static_cast<int>(c)] += weight * (mean + dot(normal, {slope[0], slope[1], slope[2]}));
      }
    }
    for (std::size_t c = 0; c < to.size(); ++c) {
      to[c][place] = static_cast<float>(std::max(0.0, sums[static_cast<int>(c)] / weights));
    }
  }
}

}  // namespace isolux
#endif
