#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/render/link_sums.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include <algorithm>

#include "isolux/render/link_sums.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

LinkSums sum(std::span<const Link> links, const SentLight& sent) {
  return sum_links_plainly(links, sent);
}

#else

constexpr std::size_t kTogether = 16;
constexpr hn::CappedTag<float, kTogether> kF;
constexpr hn::RebindToSigned<decltype(kF)> kI;
using VF = hn::Vec<decltype(kF)>;
using VI = hn::Vec<decltype(kI)>;
constexpr std::size_t kLanes = hn::MaxLanes(kF);
constexpr std::size_t kParts = kTogether / kLanes;

using Parts = VF[kParts];

// In the same order for any number of lanes.
HWY_INLINE float total(const Parts& parts) {
  float all[kTogether];
  for (std::size_t part = 0; part < kParts; ++part) {
    hn::StoreU(parts[part], kF, all + part * kLanes);
  }
  for (std::size_t half = kTogether / 2; half > 0; half /= 2) {
    for (std::size_t n = 0; n < half; ++n) all[n] += all[n + half];
  }
  return all[0];
}

template <std::size_t kChannels>
LinkSums sum_channels(std::span<const Link> links, const float* sent) {
  Parts light[kChannels], across[kChannels], along[kChannels];
  for (std::size_t c = 0; c < kChannels; ++c) {
    for (std::size_t part = 0; part < kParts; ++part) {
      light[c][part] = across[c][part] = along[c][part] = hn::Zero(kF);
    }
  }
  const auto add = [&](const Link* first, std::size_t count) HWY_ATTR {
    for (std::size_t part = 0; part < kParts; ++part) {
      static_assert(sizeof(Link) == 2 * sizeof(std::int32_t));
      const auto* words = reinterpret_cast<const std::int32_t*>(first + part * kLanes);
      const VI low = hn::LoadU(kI, words), high = hn::LoadU(kI, words + kLanes);
      const VI to = hn::ConcatEven(kI, high, low), tilts = hn::ConcatOdd(kI, high, low);
      const VF tilt_across = hn::ConvertTo(kF, hn::ShiftRight<16>(hn::ShiftLeft<16>(tilts)));
      const VF tilt_along = hn::ConvertTo(kF, hn::ShiftRight<16>(tilts));
      const VI at = kChannels == 1 ? to : hn::Add(to, hn::Add(to, to));
      for (std::size_t c = 0; c < kChannels; ++c) {
        VF from = hn::GatherIndex(kF, sent + c, at);
        if (count < kTogether) {
          const std::size_t before = std::min(count, part * kLanes);
          from = hn::IfThenElseZero(hn::FirstN(kF, count - before), from);
        }
        light[c][part] = hn::Add(light[c][part], from);
        across[c][part] = hn::MulAdd(tilt_across, from, across[c][part]);
        along[c][part] = hn::MulAdd(tilt_along, from, along[c][part]);
      }
    }
  };
  const std::size_t whole = links.size() / kTogether * kTogether;
  for (std::size_t n = 0; n < whole; n += kTogether) add(&links[n], kTogether);
  if (whole < links.size()) {
    Link rest[kTogether]{};
    std::copy(links.begin() + static_cast<std::ptrdiff_t>(whole), links.end(), rest);
    add(rest, links.size() - whole);
  }
  LinkSums sums;
  for (std::size_t c = 0; c < kChannels; ++c) {
    sums.light[c] = total(light[c]);
    sums.across[c] = total(across[c]);
    sums.along[c] = total(along[c]);
  }
  return sums;
}

LinkSums sum(std::span<const Link> links, const SentLight& sent) {
  if (sent.channels == 1) return sum_channels<1>(links, sent.of_samples);
  return sum_channels<SentLight::kMost>(links, sent.of_samples);
}

#endif

}  // namespace
}  // namespace isolux::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux {

HWY_EXPORT(sum);

LinkSums sum_links(std::span<const Link> links, const SentLight& sent) {
  return HWY_DYNAMIC_DISPATCH(sum)(links, sent);
}

LinkSums sum_links_plainly(std::span<const Link> links, const SentLight& sent) {
  LinkSums sums;
  for (const Link& link : links) {
    for (std::size_t c = 0; c < sent.channels; ++c) {
      const float from = sent.of_samples[link.to * sent.channels + c];
      sums.light[c] += from;
      sums.across[c] += link.across * from;
      sums.along[c] += link.along * from;
    }
  }
  return sums;
}

}  // namespace isolux
#endif
