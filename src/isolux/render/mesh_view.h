#pragma once

#include <cstdint>
#include <memory>

#include "isolux/intersect/mesh_surface.h"
#include "isolux/intersect/rasteriser.h"
#include "isolux/intersect/triangle_setup.h"
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

  /// Whether the block of 8 x 4 pixels from (x0, y0) can show nothing of the mesh.
  bool is_empty_at(int x0, int y0) const;
  /// Finds the triangle that each eye ray of such a block, a RayPacket's lanes, meets before its
  /// end; `rays` are those of the camera's fan. The lanes that meet one.
  std::uint32_t triangles(const RayLanes& rays, std::uint32_t lanes, int x0, int y0,
                          std::uint32_t* triangle) const;

 private:
  std::uint32_t inside_box(int x0, int y0) const;

  std::shared_ptr<const MeshSurface> surface_;
  raster::PixelBox box_{};  ///< beyond it no ray meets the mesh
  RasterBuffer raster_;
};

}  // namespace isolux
