#pragma once

#include <cstdint>
#include <vector>

#include "isolux/base/vec3.h"
#include "isolux/mesh/mesh.h"

namespace isolux {

/// The rays of a picture: origin and direction of pixel (x, y) are each first + x * along_x +
/// y * along_y; either the origins are all the same (perspective) or the directions
/// (orthographic). t counts in a direction's own length.
struct PixelRays {
  struct Plane {
    Vec3 first, along_x, along_y;
    Vec3 at(double x, double y) const { return first + x * along_x + y * along_y; }
  };
  int width = 0;
  int height = 0;
  Plane origin, direction;
};

/// For each pixel, row by row, the triangle that its ray meets first. Where in it, the ray tells
/// (RayTriangles::in_plane).
struct RasterBuffer {
  static constexpr std::uint32_t kNothing = 0xffffffff;

  int width = 0;
  int height = 0;
  std::vector<std::uint32_t> triangle;  ///< kNothing where there is none

  RasterBuffer() = default;
  RasterBuffer(int wide, int high)
      : width(wide),
        height(high),
        triangle(static_cast<std::size_t>(wide) * static_cast<std::size_t>(high), kNothing) {}

  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

/// Draws all triangles of a mesh into a buffer, on all threads: the same answer as casting the
/// pixels' rays, but for rounding where an edge passes a pixel's centre.
///
/// Triangles are sorted into tiles, and each tile is drawn by one thread in the order of their
/// numbers. A pixel belongs to a triangle where its three edge functions are positive; on an edge,
/// by the top-left rule, so that of two triangles that share it one has the pixel. Edge functions
/// are those of homogeneous coordinates (Olano and Greer 1997, "Triangle scan conversion using 2D
/// homogeneous coordinates"): triangles need not be cut where they pass the eye. Two triangles that
/// share an edge compute the very same numbers for it, but for the sign.
///
/// Both is done in lanes: candidates for pixels and edge functions for several triangles at once,
/// larger triangles for several pixels.
RasterBuffer rasterise(const Mesh& mesh, const PixelRays& rays);

/// The same, triangle by triangle and pixel by pixel: the oracle of `rasterise`.
RasterBuffer rasterise_plainly(const Mesh& mesh, const PixelRays& rays);

}  // namespace isolux
