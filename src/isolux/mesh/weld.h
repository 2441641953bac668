#pragma once

#include "isolux/mesh/mesh.h"

namespace isolux {

/// Numbers the vertices in the order in which triangles use them first; the others go.
void drop_unused_vertices(Mesh& mesh);

/// Makes one vertex of all that are equal in everything they carry, to the last bit, and drops
/// those that no triangle uses.
void weld(Mesh& mesh);

/// Positions and triangles alone, with one vertex for each place: how the surface hangs together
/// across the seams of normals and textures.
Mesh welded_by_position(const Mesh& mesh);

}  // namespace isolux
