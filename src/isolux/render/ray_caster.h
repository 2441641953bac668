#pragma once

#include <cstdint>

#include "isolux/base/progress.h"
#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// The tile around one pixel.
struct PixelView {
  SurfaceBuffer buffer;
  bool turned = false;  ///< whether the pixel's normal had to be turned towards the eye
};

/// Visibility, by casting rays or by rasterisation, as the scene says, and what lies beyond the
/// nearest surfaces.
class RayCaster {
 public:
  /// Builds what `previous` does not have.
  explicit RayCaster(const Scene& scene, const RayCaster* previous = nullptr);

  /// Every pixel of a camera, on all threads. Of two surfaces at the same place, the one named
  /// first is seen.
  SurfaceBuffer cast(const Camera& camera, const ProgressListener& listener = {}) const;
  /// The same into a buffer of the camera's size.
  void cast(const Camera& camera, SurfaceBuffer& buffer,
            const ProgressListener& listener = {}) const;

  /// The tile that pixel (x, y) lies in, with the numbers that `cast` gives it.
  PixelView cast_around(const Camera& camera, int x, int y) const;

  const SceneSurfaces& surfaces() const { return surfaces_; }

 private:
  class Eye;

  void prepare(SurfaceBuffer& buffer) const;
  /// Tiles [begin, end). Returns which normals were turned in the first, as SurfaceBuffer::hits.
  std::uint64_t cast_tiles(const Eye& eye, std::size_t begin, std::size_t end,
                           SurfaceBuffer& buffer) const;

  Scene scene_;
  SceneSurfaces surfaces_;
};

}  // namespace isolux
