#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "isolux/intersect/light_view.h"
#include "isolux/intersect/triangle_clusters.h"
#include "isolux/mesh/mesh.h"

namespace isolux {

/// Shadow rays from neighbouring points to one light, and what is in their way.
struct ShadowPacket {
  static constexpr int kCount = 16;
  static constexpr std::uint32_t kNone = ~0u;

  alignas(64) double origin[3][kCount];  ///< mm
  /// What is met before t = begin counts as near; t is 1 at a light that is a place, and counts mm
  /// towards one that is a unit direction.
  alignas(64) float begin[kCount];
  /// The triangle that the point lies on, which hides nothing from it; or kNone.
  alignas(64) std::uint32_t own[kCount];
  std::uint32_t lanes = 0;  ///< bit n: lane n is in use

  std::uint32_t far = 0;   ///< found: the lanes that meet something behind begin
  std::uint32_t near = 0;  ///< found: of the others, those that meet something with 0 < t < begin
};

/// Finds the same as a shadow ray for each lane would, by drawing the mesh as the light sees it
/// onto the rays: each is one point there. After the irregular z-buffer (Johnson, Lee, Burns and
/// Mark 2005; Aila and Laine 2004, Alias-free shadow maps). Floats with bounds for their errors
/// decide what they can; what they cannot, RayTriangles does.
/// @param clusters  of `mesh`.
/// @param view  of the mesh from `light`.
/// @returns whether it did: without vectors (scalar) it does nothing.
bool draw_shadows(const Mesh& mesh, const std::vector<TriangleCluster>& clusters,
                  const RayTarget& light, const LightView& view, std::span<ShadowPacket> packets);

}  // namespace isolux
