#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "isolux/base/progress.h"
#include "isolux/intersect/iso_surface.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// What one ray meets first among all surfaces of a scene.
struct RayHit {
  double t;             ///< mm
  std::size_t surface;  ///< place in Scene::surfaces
  Vec3 normal;          ///< unit, world space, turned towards where the ray came from
  bool turned;          ///< whether turning was needed

  SurfaceSample sample() const;
};

/// Visibility by ray casting. Holds what rays need (min-max bricks, one set for each volume).
class RayCaster {
 public:
  /// Builds the bricks, but for volumes that `previous` has; neither argument is kept.
  explicit RayCaster(const Scene& scene, const RayCaster* previous = nullptr);

  /// The nearest surface along a unit ray, t > 0; of two at the same t, the one named first.
  std::optional<RayHit> first_hit(const Ray& ray) const;

  /// Every pixel of a camera, on all threads.
  SurfaceBuffer cast(const Camera& camera, const ProgressListener& listener = {}) const;

 private:
  std::map<std::shared_ptr<const Volume>, std::shared_ptr<const BrickGrid>> bricks_;
  std::vector<IsoSurface> surfaces_;
};

}  // namespace isolux
