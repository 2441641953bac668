#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
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

/// For each pixel the triangle that its ray meets first. Where in it, the ray tells
/// (RayTriangles::in_plane). Pixels lie in tiles, row by row, and only tiles that show something
/// are kept.
class RasterBuffer {
 public:
  static constexpr std::uint32_t kNothing = 0xffffffff;
  static constexpr int kTile = 32;  ///< pixels along an edge

  RasterBuffer() = default;
  /// All tiles show nothing.
  RasterBuffer(int width, int height)
      : tiles_x_((width + kTile - 1) / kTile),
        tiles_y_((height + kTile - 1) / kTile),
        place_(tile_count(), kNothing) {}

  int tiles_x() const { return tiles_x_; }
  std::size_t tile_count() const {
    return static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y_);
  }

  /// Makes room for the pixels of those tiles, whose numbers are not defined yet.
  void keep_tiles(const std::vector<std::size_t>& tiles);
  /// The pixels of a tile; null where none are kept.
  std::uint32_t* tile(std::size_t number) {
    return place_[number] == kNothing ? nullptr : triangles_.get() + kPixels * place_[number];
  }
  const std::uint32_t* tile(std::size_t number) const {
    return const_cast<RasterBuffer*>(this)->tile(number);
  }

  /// Whether nothing is seen in all of the tile around pixel (x, y).
  bool is_empty_at(int x, int y) const { return tile(number_at(x, y)) == nullptr; }
  /// Of the picture's pixel (x, y); kNothing where there is none.
  std::uint32_t triangle(int x, int y) const {
    return is_empty_at(x, y) ? kNothing : *triangles(x, y);
  }
  /// Of that pixel and those to the right of it, in a tile that is kept.
  const std::uint32_t* triangles(int x, int y) const {
    return tile(number_at(x, y)) + (y % kTile * kTile + x % kTile);
  }

 private:
  static constexpr std::size_t kPixels = kTile * kTile;

  std::size_t number_at(int x, int y) const {
    return static_cast<std::size_t>(y / kTile) * static_cast<std::size_t>(tiles_x_) +
           static_cast<std::size_t>(x / kTile);
  }

  int tiles_x_ = 0, tiles_y_ = 0;
  std::vector<std::uint32_t> place_;  ///< of each tile among those kept
  std::unique_ptr<std::uint32_t[]> triangles_;
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

/// The triangles of the same pixels, row by row, found triangle by triangle and pixel by pixel: the
/// oracle of `rasterise`.
std::vector<std::uint32_t> rasterise_plainly(const Mesh& mesh, const PixelRays& rays);

}  // namespace isolux
