#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "isolux/base/vec3.h"
#include "isolux/mesh/mesh.h"

namespace isolux {

/// Triangles that lie together, corners beside corners, for lanes.
struct TriangleCluster {
  static constexpr std::size_t kCount = 32;

  alignas(64) float corner[3][3][kCount];  ///< mm, [corner][axis][triangle]
  std::uint32_t triangle[kCount];          ///< its number in the mesh; the last is repeated
  Vec3f low, high;                         ///< corners of a box around them all, mm
};

/// All triangles of a mesh, along a Z-order curve (Morton 1966), so that those of a cluster lie
/// near each other.
std::vector<TriangleCluster> cluster_triangles(const Mesh& mesh);

}  // namespace isolux
