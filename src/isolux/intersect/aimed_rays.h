#pragma once

#include <cstdint>

#include "isolux/intersect/iso_lanes.h"

namespace isolux {

/// A ball around a mesh.
struct MeshBall {
  Vec3 center;
  double radius = 0;  ///< mm
  double slack = 0;   ///< by how much, in mm, floats about the centre may be off
};

/// Rays in floats, about the middle of a mesh and from a little before where they come near it.
struct AimedRays {
  static constexpr int kCount = 16;

  std::uint32_t valid = 0;   ///< lanes that come near; the rest holds zeros
  bool run_together = true;  ///< they run into one octant
  alignas(64) float origin[3][kCount];
  alignas(64) float direction[3][kCount];
  alignas(64) float until[kCount];  ///< its end, in its own t

  alignas(64) double t_start[kCount];  ///< where it begins, in the ray's own t
  alignas(64) double slack[kCount];    ///< the ball's, in t
};

/// Aims those of sixteen rays, from lane `first` on, whose bit is in `lanes`, at what lies between
/// their begin and end.
void aim(const RayLanes& rays, int first, std::uint32_t lanes, const MeshBall& ball,
         AimedRays& aimed);

}  // namespace isolux
