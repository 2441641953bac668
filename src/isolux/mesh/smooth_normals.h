#pragma once

#include "isolux/mesh/mesh.h"

namespace isolux {

/// The mesh with a normal at every corner of every triangle: blended from the triangles that meet
/// in that place and face at most `crease_deg` away from this one. So edges sharper than that stay
/// sharp, and 180 smooths everything. Vertices are shared where all that they carry is equal; the
/// normals that the mesh had are not looked at.
Mesh with_smooth_normals(const Mesh& mesh, double crease_deg);

}  // namespace isolux
