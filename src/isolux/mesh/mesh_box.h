#pragma once

#include <algorithm>

#include "isolux/mesh/mesh.h"

namespace isolux {

/// The least box along the axes around all vertices, in mm. The mesh must have some.
struct MeshBox {
  Vec3 low;
  Vec3 high;
};

inline MeshBox box_of(const Mesh& mesh) {
  MeshBox box{as_double(mesh.positions[0]), as_double(mesh.positions[0])};
  for (const Vec3f& position : mesh.positions) {
    const Vec3 p = as_double(position);
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

}  // namespace isolux
