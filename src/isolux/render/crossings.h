#pragma once

#include <cstdint>

#include "isolux/render/ray_packet.h"
#include "isolux/render/scene_surfaces.h"

namespace isolux {

/// The crossings of one surface along the rays of a packet, one after the other.
class Crossings {
 public:
  /// The surface is not copied. Pieces of rays count from begin to end.
  Crossings(const PreparedSurface& surface, std::int32_t number, const RayPacket& rays);

  /// Finds the first crossing of each lane beyond from[n].
  void find(std::uint32_t lanes, const double (&from)[RayPacket::kCount]);
  /// Says that lane n has crossed the surface at t.
  void set_crossed(int n, double t, bool turned);
  /// Goes on from a crossing to the next. A crossing in the same direction just behind the last is
  /// the last again: along a ray a surface is crossed inwards and outwards in turn.
  void pass(std::uint32_t lanes);

  /// Where each lane is; lanes that have found no more have no bit in `hit`.
  const PacketHits& hits() const { return hits_; }

 private:
  double step(int n) const;

  const PreparedSurface& surface_;
  std::int32_t number_;
  RayPacket rays_;
  PacketHits hits_;
};

}  // namespace isolux
