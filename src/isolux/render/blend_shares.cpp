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
                 const std::array<const float*, 3>& normals, std::span<float* const> to) {
  blend_plainly(shares, of_samples, normals, to);
}

#else

constexpr hn::CappedTag<float, BlendShare::kPixels> kF;
constexpr hn::RebindToSigned<decltype(kF)> kI;
constexpr hn::Rebind<std::uint16_t, decltype(kF)> kU16;
using VF = hn::Vec<decltype(kF)>;

HWY_INLINE VF turned(const SlopedLight& light, VF x, VF y, VF z) {
  const auto all = [](float value) HWY_ATTR { return hn::Set(kF, value); };
  const auto& [mean, slope] = light;
  return hn::MulAdd(z, all(slope[2]),
                    hn::MulAdd(y, all(slope[1]), hn::MulAdd(x, all(slope[0]), all(mean))));
}

template <std::size_t kChannels>
void blend_channels(std::span<const BlendShare> shares, const SlopedLight* of_samples,
                    const std::array<const float*, 3>& normals, std::span<float* const> to) {
  for (std::size_t first = 0; first < BlendShare::kPixels; first += hn::Lanes(kF)) {
    const VF x = hn::LoadU(kF, normals[0] + first), y = hn::LoadU(kF, normals[1] + first),
             z = hn::LoadU(kF, normals[2] + first);
    const VF zero = hn::Zero(kF);
    VF sums[kChannels], weights = zero;
    for (VF& sum : sums) sum = zero;
    for (const BlendShare& share : shares) {
      const SlopedLight* light = of_samples + share.sample * kChannels;
      const VF weight =
          hn::ConvertTo(kF, hn::PromoteTo(kI, hn::LoadU(kU16, share.weight.data() + first)));
      weights = hn::Add(weights, weight);
      for (std::size_t c = 0; c < kChannels; ++c) {
        sums[c] = hn::MulAdd(weight, turned(light[c], x, y, z), sums[c]);
      }
    }
    const auto is_shown = hn::Gt(weights, zero);
    for (std::size_t c = 0; c < kChannels; ++c) {
      const VF light = hn::Mul(sums[c], hn::Set(kF, 1.0f / BlendShare::kWhole));
      hn::StoreU(hn::IfThenElseZero(is_shown, hn::Max(zero, light)), kF, to[c] + first);
    }
  }
}

void blend_block(std::span<const BlendShare> shares, const SlopedLight* of_samples,
                 const std::array<const float*, 3>& normals, std::span<float* const> to) {
  if (to.size() == 1) {
    blend_channels<1>(shares, of_samples, normals, to);
  } else {
    blend_channels<3>(shares, of_samples, normals, to);
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
           const std::array<const float*, 3>& normals, std::span<float* const> to) {
  HWY_DYNAMIC_DISPATCH(blend_block)(shares, of_samples, normals, to);
}

void blend_plainly(std::span<const BlendShare> shares, const SlopedLight* of_samples,
                   const std::array<const float*, 3>& normals, std::span<float* const> to) {
  for (std::size_t c = 0; c < to.size(); ++c) {
    for (std::size_t n = 0; n < BlendShare::kPixels; ++n) {
      float sum = 0;
      for (const BlendShare& share : shares) {
        if (share.weight[n] == 0) continue;
        const auto& [mean, slope] = of_samples[share.sample * to.size() + c];
        float turned = mean;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          turned = std::fma(normals[axis][n], slope[axis], turned);
        }
        sum = std::fma(static_cast<float>(share.weight[n]), turned, sum);
      }
      to[c][n] = std::max(0.0f, sum * (1.0f / BlendShare::kWhole));
    }
  }
}

}  // namespace isolux
#endif
