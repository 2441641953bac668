#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/render/blend_shares.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "isolux/render/blend_shares.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

void blend_block(std::span<const BlendShare> shares, const SlopedLight* of_samples,
                 const std::array<const float*, 3>& normals, float* const (&to)[4]) {
  blend_plainly(shares, of_samples, normals, to);
}

#else

constexpr hn::CappedTag<float, BlendShare::kPixels> kF;
constexpr hn::RebindToSigned<decltype(kF)> kI;
constexpr hn::Rebind<std::uint16_t, decltype(kF)> kU16;
using VF = hn::Vec<decltype(kF)>;

HWY_INLINE VF turned(const SlopedLight& light, std::size_t c, VF x, VF y, VF z) {
  const auto all = [](float value) HWY_ATTR { return hn::Set(kF, value); };
  return hn::MulAdd(z, all(light.slope[2][c]),
                    hn::MulAdd(y, all(light.slope[1][c]),
                               hn::MulAdd(x, all(light.slope[0][c]), all(light.mean[c]))));
}

void blend_block(std::span<const BlendShare> shares, const SlopedLight* of_samples,
                 const std::array<const float*, 3>& normals, float* const (&to)[4]) {
  for (std::size_t first = 0; first < BlendShare::kPixels; first += hn::Lanes(kF)) {
    const VF x = hn::LoadU(kF, normals[0] + first), y = hn::LoadU(kF, normals[1] + first),
             z = hn::LoadU(kF, normals[2] + first);
    VF r = hn::Zero(kF), g = r, b = r, sky = r, weights = r;
    for (const BlendShare& share : shares) {
      const SlopedLight& light = of_samples[share.sample];
      const VF weight =
          hn::ConvertTo(kF, hn::PromoteTo(kI, hn::LoadU(kU16, share.weight.data() + first)));
      weights = hn::Add(weights, weight);
      r = hn::MulAdd(weight, turned(light, 0, x, y, z), r);
      g = hn::MulAdd(weight, turned(light, 1, x, y, z), g);
      b = hn::MulAdd(weight, turned(light, 2, x, y, z), b);
      sky = hn::MulAdd(weight, turned(light, 3, x, y, z), sky);
    }
    const VF zero = hn::Zero(kF), one = hn::Set(kF, 1.0f);
    const auto is_shown = hn::Gt(weights, zero);
    const auto light_of = [&](VF sum) HWY_ATTR {
      const VF light = hn::Mul(sum, hn::Set(kF, 1.0f / BlendShare::kWhole));
      return hn::IfThenElseZero(is_shown, hn::Max(zero, light));
    };
    hn::StoreU(light_of(r), kF, to[0] + first);
    hn::StoreU(light_of(g), kF, to[1] + first);
    hn::StoreU(light_of(b), kF, to[2] + first);
    hn::StoreU(hn::Min(one, light_of(sky)), kF, to[3] + first);
  }
}

#endif

}  // namespace
}  // namespace isolux::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux {

HWY_EXPORT(blend_block);

void blend(std::span<const BlendShare> shares, const SlopedLight* of_samples,
           const std::array<const float*, 3>& normals, float* const (&to)[4]) {
  HWY_DYNAMIC_DISPATCH(blend_block)(shares, of_samples, normals, to);
}

void blend_plainly(std::span<const BlendShare> shares, const SlopedLight* of_samples,
                   const std::array<const float*, 3>& normals, float* const (&to)[4]) {
  for (std::size_t n = 0; n < BlendShare::kPixels; ++n) {
    SampleLight sum{};
    for (const BlendShare& share : shares) {
      if (share.weight[n] == 0) continue;
      const auto& [mean, slope] = of_samples[share.sample];
      for (std::size_t c = 0; c < sum.size(); ++c) {
        float turned = mean[c];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          turned = std::fma(normals[axis][n], slope[axis][c], turned);
        }
        sum[c] = std::fma(static_cast<float>(share.weight[n]), turned, sum[c]);
      }
    }
    for (std::size_t c = 0; c < sum.size(); ++c) {
      to[c][n] = std::max(0.0f, sum[c] * (1.0f / BlendShare::kWhole));
    }
    to[3][n] = std::min(1.0f, to[3][n]);
  }
}

}  // namespace isolux
#endif
