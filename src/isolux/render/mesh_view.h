#pragma once

#include <memory>
#include <optional>

#include "isolux/intersect/mesh_surface.h"
#include "isolux/intersect/rasteriser.h"
#include "isolux/scene/camera.h"

namespace isolux {

/// What one camera sees of one mesh: by rays, as they are asked for, or rasterised beforehand. Both
/// give the same numbers for the same triangle.
class MeshView {
 public:
  /// Casts rays.
  MeshView(std::shared_ptr<const MeshSurface> surface, const Camera& camera);
  /// Rasterises.
  MeshView(const Mesh& mesh, const Camera& camera);

  /// What the eye ray of pixel (x, y) meets before t_max; t as the camera's fan counts it.
  std::optional<MeshHit> hit(int x, int y, double t_max) const;

 private:
  std::shared_ptr<const MeshSurface> surface_;
  RayFan fan_;
  RasterBuffer raster_;
};

}  // namespace isolux
