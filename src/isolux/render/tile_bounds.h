#pragma once

#include <vector>

#include "isolux/base/affine.h"
#include "isolux/intersect/skip_grid.h"
#include "isolux/scene/camera.h"

namespace isolux {

/// Between which depths the rays of a tile can meet an isosurface, from the blocks of its skip
/// grid, drawn as spheres. A tile whose `near` is infinite shows nothing of it.
struct TileBounds {
  int tiles_x = 0;
  std::vector<float> near, far;  ///< mm from the eye's plane along the line of sight

  TileBounds(const SkipGrid& skip, const Affine& world_from_index, const Camera& camera,
             int tile_size);
};

}  // namespace isolux
