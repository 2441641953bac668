#pragma once

#include <cstddef>

#include "isolux/mesh/mesh.h"

namespace isolux {

/// How the triangles of a mesh hang together by the vertices that they share.
struct MeshTopology {
  std::size_t vertices = 0;  ///< that a triangle uses
  std::size_t edges = 0;
  std::size_t triangles = 0;
  std::size_t border_edges = 0;         ///< of one triangle
  std::size_t crowded_edges = 0;        ///< of more than two triangles
  std::size_t inconsistent_edges = 0;   ///< of two triangles that run along them in one direction
  std::size_t collapsed_triangles = 0;  ///< that use a vertex twice; their edges are not counted

  bool is_watertight() const {
    return triangles > 0 && border_edges == 0 && crowded_edges == 0 && inconsistent_edges == 0;
  }
  /// Vertices - edges + triangles: 2 for a sphere, 0 for a torus.
  long long euler_characteristic() const {
    return static_cast<long long>(vertices) - static_cast<long long>(edges) +
           static_cast<long long>(triangles - collapsed_triangles);
  }
};

MeshTopology topology_of(const Mesh& mesh);

}  // namespace isolux
