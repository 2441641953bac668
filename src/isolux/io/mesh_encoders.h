#pragma once

#include <string>

#include "isolux/io/write_mesh.h"

namespace isolux {

/// The bytes of a mesh file. STL: facets alone. PLY: normals, colours (as sRGB bytes) and texture
/// points as well. OBJ: the same, colours (sRGB from 0 to 1) behind the positions. GLB: all there
/// is.
std::string as_stl(const Mesh& mesh, MeshSpace space);
std::string as_ply(const Mesh& mesh, MeshSpace space);
std::string as_obj(const Mesh& mesh, MeshSpace space);
std::string as_glb(const Mesh& mesh, MeshSpace space);

}  // namespace isolux
