#pragma once

#include <array>
#include <span>

#include "isolux/render/transport_links.h"

namespace isolux {

/// Light that samples send: `channels` numbers for each, 1 where all light is grey, else 3.
struct SentLight {
  static constexpr std::size_t kMost = 3;

  std::size_t channels;
  const float* of_samples;  ///< [sample * channels + channel], of each that a link leads to
  std::array<float, kMost> sky;
};

/// What links bring, by channel: their light, and it times their tilts, in LinkTilt's steps.
struct LinkSums {
  std::array<float, SentLight::kMost> light{}, across{}, along{};
};

/// The sums over links, in lanes: sixteen of them at a time, whose sums are then added in pairs.
LinkSums sum_links(std::span<const Link> links, const SentLight& sent);
/// The same plainly, one after another.
LinkSums sum_links_plainly(std::span<const Link> links, const SentLight& sent);

}  // namespace isolux
