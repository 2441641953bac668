#pragma once

#include <cstdint>

#include "isolux/intersect/iso_lanes.h"
#include "isolux/mesh/mesh.h"

namespace isolux {

/// The points where rays side by side meet given triangles.
struct MeshPointLanes {
  std::uint32_t met = 0;     ///< bit n: lane n; not where a ray runs in its triangle's plane
  std::uint32_t turned = 0;  ///< lanes whose normal was turned round, to where the ray came from
  alignas(64) double t[RayLanes::kCount];
  alignas(64) float u[RayLanes::kCount], v[RayLanes::kCount];
  /// The shading normal, unit, on the side that the ray came from; zero where there is none.
  alignas(64) float normal[3][RayLanes::kCount];
};

/// For lane n of `lanes`, where its ray (in world space) meets the plane of triangle[n], and the
/// shading normal there: to the last bit as RayTriangles::in_plane and shading_normal say, but on
/// vectors of lanes.
void find_mesh_points(const Mesh& mesh, const RayLanes& rays, const std::uint32_t* triangle,
                      std::uint32_t lanes, MeshPointLanes& points);

}  // namespace isolux
