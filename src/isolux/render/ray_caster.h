#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "isolux/base/progress.h"
#include "isolux/intersect/iso_lanes.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// What one pixel's eye ray meets first among all surfaces of a scene.
struct PixelHit {
  SurfaceSample sample;
  bool turned = false;  ///< whether the normal had to be turned towards the eye
};

/// Visibility by ray casting. Holds what rays need: min-max bricks, one set for each volume, and
/// skip structures, one for each volume and iso value.
class RayCaster {
 public:
  /// Builds what `previous` does not have; neither argument is kept.
  explicit RayCaster(const Scene& scene, const RayCaster* previous = nullptr);

  /// Every pixel of a camera, on all threads. Of two surfaces at the same place, the one named
  /// first is seen.
  SurfaceBuffer cast(const Camera& camera, const ProgressListener& listener = {}) const;
  /// The same into a buffer of the camera's size.
  void cast(const Camera& camera, SurfaceBuffer& buffer,
            const ProgressListener& listener = {}) const;

  /// One pixel, with the numbers that `cast` gives it.
  PixelHit cast_pixel(const Camera& camera, int x, int y) const;

 private:
  using VolumeAndIso = std::pair<std::shared_ptr<const Volume>, double>;

  std::map<std::shared_ptr<const Volume>, std::shared_ptr<const BrickGrid>> bricks_;
  std::map<VolumeAndIso, std::shared_ptr<const IsoLanes>> lanes_;
  std::vector<std::shared_ptr<const IsoLanes>> surfaces_;  ///< as in Scene::surfaces
};

}  // namespace isolux
