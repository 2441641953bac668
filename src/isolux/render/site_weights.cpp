#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/render/site_weights.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "isolux/render/site_weights.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

void weigh(const BlendPoints& points, const SampleSite* sites, std::span<const std::uint32_t> which,
           std::vector<SiteWeights>& to) {
  weigh_sites_plainly(points, sites, which, to);
}

#else

constexpr hn::CappedTag<float, BlendPoints::kCount> kF;
using VF = hn::Vec<decltype(kF)>;
constexpr std::size_t kLanes = hn::MaxLanes(kF);

constexpr float kReachScale = 1 / (kBlendReach * kBlendReach);

HWY_INLINE VF all(float value) { return hn::Set(kF, value); }
HWY_INLINE VF square(VF a) { return hn::Mul(a, a); }
HWY_INLINE VF dot(VF ax, VF ay, VF az, VF bx, VF by, VF bz) {
  return hn::MulAdd(az, bz, hn::MulAdd(ay, by, hn::Mul(ax, bx)));
}
// (1 - a)^2 where a < 1.
HWY_INLINE VF falling(VF a) { return square(hn::Max(hn::Zero(kF), hn::Sub(all(1), a))); }

// The weights in the lanes from `first` on.
HWY_INLINE VF weights_of(const SampleSite& site, const BlendPoints& points, std::size_t first) {
  const auto from_origin = [](float at, double origin) {
    return static_cast<float>(static_cast<double>(at) - origin);
  };
  const float thickness = blend_thickness(site, points);
  const auto of = [first](const BlendPoints::Floats& floats)
                      HWY_ATTR { return hn::LoadU(kF, floats.data() + first); };
  const auto& [sx, sy, sz] = site.in_blocks;
  const VF dx = hn::Sub(all(from_origin(sx, points.origin.x)), of(points.x)),
           dy = hn::Sub(all(from_origin(sy, points.origin.y)), of(points.y)),
           dz = hn::Sub(all(from_origin(sz, points.origin.z)), of(points.z));
  const VF off = dot(dx, dy, dz, of(points.across_x), of(points.across_y), of(points.across_z));
  const VF likeness =
      hn::Max(hn::Zero(kF), dot(all(site.normal.x), all(site.normal.y), all(site.normal.z),
                                of(points.normal_x), of(points.normal_y), of(points.normal_z)));
  const VF near = hn::Mul(falling(hn::Mul(all(kReachScale), dot(dx, dy, dz, dx, dy, dz))),
                          falling(hn::Mul(all(1 / (thickness * thickness)), square(off))));
  return hn::Mul(near, square(square(square(likeness))));
}

void weigh(const BlendPoints& points, const SampleSite* sites, std::span<const std::uint32_t> which,
           std::vector<SiteWeights>& to) {
  for (const std::uint32_t number : which) {
    SiteWeights found;
    found.which = number;
    found.lanes = 0;
    for (std::size_t first = 0; first < BlendPoints::kCount; first += kLanes) {
      const VF weights = weights_of(sites[number], points, first);
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(kF, hn::Gt(weights, hn::Zero(kF)), bits);
      found.lanes |= (bits[0] | std::uint32_t{bits[1]} << 8) << first;
      hn::StoreU(weights, kF, found.weight.data() + first);
    }
    found.lanes &= points.mask;
    if (found.lanes != 0) to.push_back(found);
  }
}

#endif

}  // namespace
}  // namespace isolux::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux {

HWY_EXPORT(weigh);

void weigh_sites(const BlendPoints& points, const SampleSite* sites,
                 std::span<const std::uint32_t> which, std::vector<SiteWeights>& to) {
  HWY_DYNAMIC_DISPATCH(weigh)(points, sites, which, to);
}

void weigh_sites_plainly(const BlendPoints& points, const SampleSite* sites,
                         std::span<const std::uint32_t> which, std::vector<SiteWeights>& to) {
  const auto falling = [](double a) {
    const double rest = std::max(0.0, 1 - a);
    return rest * rest;
  };
  for (const std::uint32_t number : which) {
    const SampleSite& site = sites[number];
    const double thickness = blend_thickness(site, points), reach = kBlendReach;
    SiteWeights found{number, 0, {}};
    for (std::size_t n = 0; n < BlendPoints::kCount; ++n) {
      const Vec3 away =
          as_double(site.in_blocks) - points.origin - Vec3{points.x[n], points.y[n], points.z[n]};
      const double off = dot(away, {points.across_x[n], points.across_y[n], points.across_z[n]});
      const double likeness =
          dot(as_double(site.normal), {points.normal_x[n], points.normal_y[n], points.normal_z[n]});
      found.weight[n] = static_cast<float>(falling(dot(away, away) / (reach * reach)) *
                                           falling(off * off / (thickness * thickness)) *
                                           std::pow(std::max(0.0, likeness), 8));
      if (found.weight[n] > 0) found.lanes |= 1u << n;
    }
    found.lanes &= points.mask;
    if (found.lanes != 0) to.push_back(found);
  }
}

}  // namespace isolux
#endif
