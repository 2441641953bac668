#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "isolux/base/vec3f.h"
#include "isolux/render/scene_surfaces.h"

namespace isolux {

/// A block by its least corner.
using BlockIndex = std::array<std::int32_t, 3>;

/// A point of a surface that may stand for what is around it.
struct SurfacePlace {
  Vec3 position;         ///< mm, on the surface
  Vec3f normal;          ///< unit: the shading normal, on the surface's outside
  Vec3f true_normal;     ///< unit: that of the surface itself, on the same side
  BlockIndex block;      ///< that it lies in
  MeshPoint point = {};  ///< on a mesh
};

/// The space in which a surface's blocks are the cubes between whole numbers: edge^3 cells each,
/// edge 1, 2 or 4; for a mesh so large that about 160,000 / edge^2 of their faces have its area.
Affine block_from_world(const PreparedSurface& surface, int edge);

inline BlockIndex block_of(Vec3 in_blocks) {
  return {static_cast<std::int32_t>(std::floor(in_blocks.x)),
          static_cast<std::int32_t>(std::floor(in_blocks.y)),
          static_cast<std::int32_t>(std::floor(in_blocks.z))};
}

/// Places all over an isosurface, one for each cell that it passes through, in the order of their
/// blocks: those of one block follow each other.
std::vector<SurfacePlace> places_of(const IsoLanes& lanes, int edge);

/// Places all over a mesh, spread evenly by area, some four for each block's face, in the order of
/// their blocks.
std::vector<SurfacePlace> places_of(const Mesh& mesh, const Affine& block_from_world);

}  // namespace isolux
