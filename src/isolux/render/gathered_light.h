#pragma once

#include "isolux/render/blend_shares.h"
#include "isolux/render/link_sums.h"

namespace isolux {

/// The mean of what a sample's links lead to, for each channel that is sent.
std::array<float, SentLight::kMost> gathered_light(const SampleLinks& row, const SentLight& sent);

/// The same, into `to` channel by channel, and how it would change if the links' shares went by
/// another normal than the sample's. Where light comes evenly from all around, a share grows by 3/2
/// of its link's tilt towards that normal, to first order; 5/4 errs as little, and less to one
/// side, for links from below the sample's horizon are missing. Shares go on making 1, so even
/// light stays even.
void gather_sloped(const SampleLinks& row, const SentLight& sent, Vec3 normal, SlopedLight* to);

/// The same without what is close.
void gather_further(const SampleLinks& row, const SentLight& sent, Vec3 normal, SlopedLight* to);

/// The share of what is close.
SlopedLight close_share(const SampleLinks& row, Vec3 normal);

/// The same for the share of open sky.
SlopedLight sloped_sky(const SampleLinks& row, Vec3 normal);

}  // namespace isolux
