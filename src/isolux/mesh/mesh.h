#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "isolux/base/vec3f.h"
#include "isolux/image/picture.h"
#include "isolux/shade/material.h"

namespace isolux {

struct MeshMaterial {
  std::string name;
  Material material;
  std::shared_ptr<const Picture> base_color;  ///< sRGB; multiplies ka and kd; null: none
};

/// A range of triangles with one material.
struct MeshPart {
  std::uint32_t first_triangle = 0;
  std::uint32_t triangle_count = 0;
  std::uint32_t material = 0;  ///< place in Mesh::materials
};

/// A point of a texture: (0, 0) is its lower left corner, (1, 1) its upper right.
struct TexturePoint {
  float u = 0;
  float v = 0;
};

/// Triangles in world space (millimetres, LPS). Seen from outside, the vertices of a triangle run
/// counter-clockwise.
struct Mesh {
  using Triangle = std::array<std::uint32_t, 3>;

  std::vector<Vec3f> positions;  ///< mm, finite
  std::vector<Vec3f>
      normals;  ///< unit, or 0 for "the triangle's own"; one a vertex; or none at all
  std::vector<TexturePoint> texture_points;  ///< one a vertex; or none at all
  std::vector<Vec3f> colors;                 ///< linear RGB, one a vertex; or none at all
  std::vector<Triangle> triangles;           ///< places in `positions`
  std::vector<MeshMaterial> materials;
  std::vector<MeshPart> parts;  ///< all triangles, in order; none of them empty
};

/// A point of a mesh: (1 - u - v) a + u b + v c of a triangle's corners.
struct MeshPoint {
  std::uint32_t triangle = 0;
  float u = 0;
  float v = 0;
};

/// The three corners of a triangle, in mm.
inline std::array<Vec3, 3> corners(const Mesh& mesh, const Mesh::Triangle& triangle) {
  return {as_double(mesh.positions[triangle[0]]), as_double(mesh.positions[triangle[1]]),
          as_double(mesh.positions[triangle[2]])};
}

}  // namespace isolux
