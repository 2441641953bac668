#pragma once

#include <vector>

#include "isolux/base/affine.h"
#include "isolux/intersect/skip_grid.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/camera.h"

namespace isolux {

/// Between which depths the rays of a tile can meet an isosurface, from the blocks of its skip
/// grid (or larger cubes, where blocks are but a few pixels), drawn as boxes along the axes of
/// camera space. A tile whose `near` is infinite shows nothing of it.
struct TileBounds {
  static constexpr int kPixels = SurfaceBuffer::kBlock;  ///< along a tile's edge

  int tiles_x = 0;
  std::vector<float> near, far;  ///< mm from the eye's plane along the line of sight

  /// The tile of pixel (x, y), both >= 0.
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y / kPixels) * static_cast<std::size_t>(tiles_x) +
           static_cast<std::size_t>(x / kPixels);
  }

  TileBounds(const SkipGrid& skip, const Affine& world_from_index, const Camera& camera);
};

}  // namespace isolux
