#pragma once

#include <string>
#include <string_view>

#include "isolux/io/write_mesh.h"

namespace isolux {

/// What a mesh file is, by its first bytes (512 are enough), or by its name's ending where they do
/// not tell: "stl", "ply", "obj", "gltf", "glb", or an empty text. `bytes`: of the whole file.
std::string mesh_kind(const std::string& path, std::string_view first_bytes, double bytes);

/// The axes that the tag SPACE= in a file's first bytes names; LPS where there is none.
MeshSpace mesh_space(const std::string& kind, std::string_view first_bytes);

/// @throws WorkError  where the counts in an STL or PLY header promise more than `bytes` can hold,
/// or a PLY header does not end within `first_bytes` (which libraries look for without end).
void check_mesh_promise(const std::string& path, const std::string& kind,
                        std::string_view first_bytes, double bytes);

}  // namespace isolux
