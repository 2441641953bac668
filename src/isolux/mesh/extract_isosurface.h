#pragma once

#include "isolux/mesh/mesh.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// The isosurface of a volume as triangles (see CellTriangulations), with one material.
///
/// - Vertices lie where the surface crosses the grid's edges, on the interpolant's own root there;
///   the few inside a cell lie on the interpolant too, as far as Newton's method brings them.
/// - Every edge is shared by two triangles, in opposite directions, but where the surface ends: at
///   the volume's border, and at cells with a corner that is not finite.
/// - Normals are the contract's, towards lower values, and so is the outside.
/// - A voxel exactly at the iso value counts as inside, and then several vertices lie in it:
///   triangles without area among them keep the surface closed.
///
/// The same bytes for any number of threads.
/// @throws WorkError  where the mesh would take more memory than may be used.
Mesh extract_isosurface(const Volume& volume, double iso);

}  // namespace isolux
