#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "isolux/base/ray.h"
#include "isolux/intersect/iso_lanes.h"
#include "isolux/intersect/mesh_surface.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// An isosurface or a mesh for rays that belong to no picture.
class LooseRays {
 public:
  explicit LooseRays(const SurfaceItem& surface);

  /// How many of the rays (in world space) meet the surface. With a lamp, to which they all run, it
  /// is only asked whether they do, and not where first. Those that follow each other go together,
  /// on all threads.
  std::size_t count_hits(const std::vector<Ray>& rays, const std::optional<Vec3>& lamp = {}) const;

 private:
  std::size_t count_hidden(const std::vector<Ray>& rays, Vec3 lamp) const;

  std::optional<Affine> surface_from_world_;
  std::optional<IsoLanes> lanes_;    ///< of an isosurface
  std::optional<MeshSurface> tree_;  ///< of a mesh
};

}  // namespace isolux
