#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "isolux/base/ray.h"
#include "isolux/intersect/iso_lanes.h"
#include "isolux/intersect/mesh_surface.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// What is asked of a ray: where it first meets the surface, or whether it does.
enum class RayQuery { kNearest, kAny };

/// An isosurface or a mesh for rays that belong to no picture.
class LooseRays {
 public:
  explicit LooseRays(const SurfaceItem& surface);

  /// How many of the rays (in world space) meet the surface; those that follow each other go
  /// together, on all threads.
  std::size_t count_hits(const std::vector<Ray>& rays, RayQuery query) const;

 private:
  std::optional<Affine> surface_from_world_;
  std::optional<IsoLanes> lanes_;    ///< of an isosurface
  std::optional<MeshSurface> tree_;  ///< of a mesh
};

}  // namespace isolux
