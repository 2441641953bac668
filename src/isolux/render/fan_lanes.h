#pragma once

#include <cstdint>

#include "isolux/intersect/iso_lanes.h"
#include "isolux/render/ray_packet.h"
#include "isolux/scene/camera.h"

namespace isolux {

/// The rays of a fan through the 8 x 4 pixels from (x0, y0), lane for lane as RayPacket has them,
/// to the bit as RayFan::ray gives them. Begin and end are left alone.
void aim(const RayFan& fan, int x0, int y0, RayLanes& rays);

/// The same with unit directions, to the bit as Camera::ray gives them.
void aim_unit(const RayFan& fan, int x0, int y0, RayLanes& rays);

/// Makes t, counted in the lengths of these directions, a distance, for all lanes. Returns the
/// lanes that are hit and have no normal.
std::uint32_t measure(const RayLanes& rays, PacketHits& hits);

}  // namespace isolux
