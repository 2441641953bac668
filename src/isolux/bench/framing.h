#pragma once

#include "isolux/base/vec3.h"

namespace isolux {

/// Where a perspective camera stands; up is +z.
struct View {
  Vec3 eye;
  Vec3 target;
  double fov_deg = 30;
};

// Views of a volume whose box reaches from 0 to `box_mm`, turning by 1 degree a turn about z.

/// The whole box from outside, where its sphere just fits; at 0 degrees from -y, a little above.
View orbit_view(Vec3 box_mm, double turn_deg);
/// From outside on the same orbit, but so near that a head fills most of the picture.
View close_view(Vec3 box_mm, double turn_deg);
/// From the middle of the braincase outwards, with a wide angle.
View inside_view(Vec3 box_mm, double turn_deg);

}  // namespace isolux
