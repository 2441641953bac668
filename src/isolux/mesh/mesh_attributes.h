#pragma once

#include "isolux/mesh/mesh.h"

namespace isolux {

/// Unit, towards the outside: the vertices' normals, blended, or the triangle's own where there are
/// none. 0 for a triangle without area.
Vec3 shading_normal(const Mesh& mesh, const MeshPoint& point);

/// The material of the triangle, with ka and kd multiplied by the colours of vertices and texture.
/// Textures are read between their pixels' centres, and repeat.
Material material_at(const Mesh& mesh, const MeshPoint& point);

/// Whether the material is the same all over: that of the first part.
bool has_one_material(const Mesh& mesh);

}  // namespace isolux
