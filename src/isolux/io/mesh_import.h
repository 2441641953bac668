#pragma once

#include <cstdint>
#include <string>

#include "isolux/base/fence.h"

namespace isolux {

/// A mesh file whose kind is known.
struct MeshFile {
  std::string path;
  std::string ending;  ///< "stl", "ply", "obj", "gltf" or "glb": what it is, whatever its name
};

/// What is sent of a material, before its texts (its name, and its texture: see import_mesh).
struct ImportedMaterial {
  double ka[3], kd[3], ks[3];
  double shininess;
  std::uint8_t is_given;  ///< the file says something of it
  std::uint8_t is_texture_embedded;
};

/// What is sent of a part, before its arrays: 3 doubles a position; 3 a normal; 2 a texture point;
/// 3 a colour, as the file has it; 3 indices a triangle.
struct ImportedPart {
  std::uint64_t vertices, triangles;
  std::uint64_t other_faces;  ///< points and lines, left out
  std::uint32_t material;
  std::uint8_t has_normals, has_texture_points, has_colors;
};

/// Reads a mesh with assimp and sends what is in it, in the file's own space, each node's meshes
/// with its transform: an empty text (or why it cannot be read); the number of further files that
/// were opened, and their paths; that of files that were not to be had, and what they were called;
/// that of materials, and each with its texts (its name; its texture's bytes where embedded, else
/// its file as the material calls it, or an empty text); that of parts, and each with its arrays.
/// All unchecked. To be called inside a fence only (isolux/base/fence.h). May throw anything.
void import_mesh(const MeshFile& file, FenceOutput& output);

}  // namespace isolux
