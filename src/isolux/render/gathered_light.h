#pragma once

#include "isolux/render/blend_shares.h"
#include "isolux/render/transport_links.h"

namespace isolux {

/// The mean of what a sample's links lead to. `sent`: of each sample that a link may lead to; `sky`:
/// of the open sky.
SampleLight gathered_light(const SampleLinks& row, const SampleLight* sent, const SampleLight& sky);

/// The same, and how it would change if the links' shares went by another normal than the sample's:
/// to first order a share grows by 3/2 of its link's tilt towards that normal, as it would if light
/// came evenly from all around. Shares go on making 1, so even light stays even.
SlopedLight gathered_sloped(const SampleLinks& row, const SampleLight* sent, const SampleLight& sky,
                            Vec3 normal);

}  // namespace isolux
