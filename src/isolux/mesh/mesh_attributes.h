#pragma once

#include "isolux/mesh/mesh.h"

namespace isolux {

/// What a mesh carries at the point (1 - u - v) a + u b + v c of a triangle's corners.

/// Unit, towards the outside: the vertices' normals, blended, or the triangle's own where there are
/// none. 0 for a triangle without area.
Vec3 shading_normal(const Mesh& mesh, std::uint32_t triangle, double u, double v);

/// The material of a triangle, with ka and kd multiplied by the colours of vertices and texture.
/// Textures are read between their pixels' centres, and repeat.
Material material_at(const Mesh& mesh, std::uint32_t triangle, double u, double v);

}  // namespace isolux
