#pragma once

#include "isolux/mesh/mesh.h"

namespace isolux {

/// About `share` of the triangles (in (0, 1]), by collapsing the edges that matter least (Garland
/// and Heckbert 1997, "Surface simplification using quadric error metrics", as meshoptimizer does
/// it). Vertices stay where they are, so that they keep their normals; borders stay whole.
Mesh simplified(const Mesh& mesh, double share);

}  // namespace isolux
