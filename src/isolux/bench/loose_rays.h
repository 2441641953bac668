#pragma once

#include <vector>

#include "isolux/base/ray.h"
#include "isolux/intersect/iso_lanes.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// An isosurface for rays that belong to no picture.
class LooseRays {
 public:
  explicit LooseRays(const IsoSurfaceItem& surface);

  /// How many of the rays (in world space) meet the surface; those that follow each other go
  /// together, on all threads.
  std::size_t count_hits(const std::vector<Ray>& rays) const;

 private:
  Affine index_from_world_;
  IsoLanes lanes_;
};

}  // namespace isolux
