#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "isolux/base/progress.h"
#include "isolux/intersect/iso_lanes.h"
#include "isolux/intersect/mesh_surface.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// What one pixel's eye ray meets first among all surfaces of a scene.
struct PixelHit {
  SurfaceSample sample;
  bool turned = false;  ///< whether the normal had to be turned towards the eye
};

/// Visibility, by casting rays or by rasterisation, as the scene says. Holds what rays need:
/// min-max bricks, one set for each volume; skip structures, one for each volume and iso value;
/// Embree's trees, one for each mesh; or, to rasterise, the meshes of isosurfaces.
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
  /// One of Scene::surfaces, made ready: lanes; or a mesh, with its tree where rays are cast.
  struct Prepared {
    std::shared_ptr<const IsoLanes> lanes;
    std::shared_ptr<const Mesh> mesh;
    std::shared_ptr<const MeshSurface> tree;
  };
  class Eye;

  Prepared prepared(const SurfaceItem& item, Visibility visibility, const RayCaster* previous);

  std::map<std::shared_ptr<const Volume>, std::shared_ptr<const BrickGrid>> bricks_;
  std::map<VolumeAndIso, std::shared_ptr<const IsoLanes>> lanes_;
  std::map<VolumeAndIso, std::shared_ptr<const Mesh>> meshes_;
  std::map<std::shared_ptr<const Mesh>, std::shared_ptr<const MeshSurface>> trees_;
  std::vector<Prepared> surfaces_;  ///< as in Scene::surfaces
  bool has_painted_ = false;
};

}  // namespace isolux
