#pragma once

#include <string>
#include <vector>

#include "isolux/mesh/mesh.h"

namespace isolux {

/// The axes of a mesh file: LPS, or RAS, which is LPS with x and y negated.
enum class MeshSpace { kLps, kRas };

/// Writes a mesh in the format that the name's ending says: binary .stl and .ply, .obj, .glb. The
/// first three hold millimetres and carry the tag SPACE=LPS or SPACE=RAS, as 3D Slicer writes and
/// reads it. glTF has axes and units of its own (metres, +y up, +z to the front): a .glb holds LPS
/// millimetres under a node that carries them there, upright and with the face to the front.
/// The file that was there survives a failure. The mesh must have triangles.
/// @throws UsageError  another ending, or RAS for .glb. @throws WorkError  cannot be written.
void write_mesh(const std::string& path, const Mesh& mesh, MeshSpace space);

/// What the format that the name says has no place for, a sentence each.
std::vector<std::string> mesh_losses(const std::string& path, const Mesh& mesh);

/// @throws UsageError  where write_mesh would not know the ending.
void check_mesh_name(const std::string& path, MeshSpace space);

}  // namespace isolux
