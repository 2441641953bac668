#pragma once

#include <cstdint>
#include <vector>

#include "isolux/render/ray_packet.h"
#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_buffer.h"

namespace isolux {

/// Finds further points. Layers lie along a ray in order of distance, every crossing is one; they
/// end where less than kLeastWeight of the light comes through. A perfect mirror sends the ray on
/// about the shading normal; where that dips below the surface itself, it is reflected about the
/// surface's tangent plane.
class FurtherPointFinder {
 public:
  static constexpr double kLeastWeight = 1e-6;
  /// Rays and points that 32 pixels may come to.
  static constexpr std::size_t kMostAtOnce = 1 << 20;

  /// Neither argument is copied.
  FurtherPointFinder(const Scene& scene, const SceneSurfaces& surfaces);

  /// Adds to `points` what lies beyond the nearest hits of eye rays (of unit direction, t in mm).
  /// Lane n is pixel first_pixel + n of the tile.
  /// @throws WorkError  where translucent mirrors multiply to more than kMostAtOnce.
  void find(const RayPacket& eye_rays, const PacketHits& nearest, std::uint8_t first_pixel,
            FurtherPoints& points) const;

 private:
  struct Branch;
  class Layers;

  const Material& material(std::int32_t surface) const;
  void reflect(const Branch& branch, const PacketHits& hits, int n,
               std::vector<Branch>& mirrored) const;
  void follow(const std::vector<Branch>& branches, FurtherPoints& points,
              std::vector<Branch>& mirrored) const;

  const Scene& scene_;
  const SceneSurfaces& surfaces_;
};

}  // namespace isolux
