#pragma once

#include "isolux/render/blend_shares.h"
#include "isolux/render/transport_links.h"

namespace isolux {

/// The mean of what a sample's links lead to. `sent`: of each sample that a link may lead to;
/// `sky`: of the open sky.
SampleLight gathered_light(const SampleLinks& row, const SampleLight* sent, const SampleLight& sky);

/// The same, and how it would change if the links' shares went by another normal than the sample's.
/// Where light comes evenly from all around, a share grows by 3/2 of its link's tilt towards that
/// normal, to first order; 5/4 errs as little, and less to one side, for links from below the
/// sample's horizon are missing. Shares go on making 1, so even light stays even.
SlopedLight gathered_sloped(const SampleLinks& row, const SampleLight* sent, const SampleLight& sky,
                            Vec3 normal);

}  // namespace isolux
