#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "isolux/base/vec3.h"
#include "isolux/mesh/mesh.h"

namespace isolux {

/// What one eye ray meets first, as precisely as a SurfaceBuffer keeps it.
struct SurfaceSample {
  static constexpr std::int32_t kNothing = -1;

  double depth_mm = std::numeric_limits<double>::infinity();  ///< along the eye ray
  float normal_x = 0;  ///< unit, world space, turned towards the eye; 0 where nothing is met
  float normal_y = 0;
  float normal_z = 0;
  std::int32_t surface = kNothing;  ///< place in Scene::surfaces
  MeshPoint point = {};             ///< where on it, if it is a mesh

  bool is_hit() const { return surface != kNothing; }
  Vec3 normal() const { return {normal_x, normal_y, normal_z}; }
};

/// Something beyond what the eye ray of a pixel meets first that adds to its colour: a deeper layer
/// behind translucent surfaces, what a mirror shows, or the background through either.
struct FurtherPoint {
  static constexpr std::int32_t kBackground = -1;

  std::uint8_t pixel = 0;    ///< its place in the tile
  bool is_mirrored = false;  ///< whether a mirror lies between
  std::int32_t surface = kBackground;
  /// What the way to the eye leaves of its radiance, per channel; its own opacity comes on top.
  float weight[3] = {};
  float normal[3] = {};  ///< unit, on the side that the ray came from
  float to_eye[3] = {};  ///< unit, back along the ray that met it
  double came_mm = 0;    ///< length of that ray
  Vec3 position = {};    ///< mm
  MeshPoint point = {};
};

/// One tile's, in the order in which they are found: fixed by the scene, not by threads.
using FurtherPoints = std::vector<FurtherPoint>;

/// For each pixel, what the eye ray meets first, and nothing of light: distance, shading normal and
/// surface number. The position is the camera's ray at that distance, to the precision of doubles.
///
/// Pixels lie in tiles of 8 x 8, each of four blocks of 4 x 4, so that sixteen lanes read and write
/// what is next to each other in both ways; `at` knows the order. Tiles reach over the right and
/// lower edges of the picture. Where a pixel has no bit in `hits`, its numbers mean nothing.
class SurfaceBuffer {
 public:
  static constexpr int kTile = 8;  ///< pixels along an edge
  static constexpr int kTilePixels = 64;
  static constexpr int kBlock = 4;
  static constexpr int kBlockPixels = 16;

  SurfaceBuffer(int width, int height)
      : width_(width),
        height_(height),
        tiles_x_((width + kTile - 1) / kTile),
        tiles_y_((height + kTile - 1) / kTile),
        hits(static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y_)),
        depth_mm(pixels()),
        normal_x(pixels()),
        normal_y(pixels()),
        normal_z(pixels()),
        surface(pixels()) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int tiles_x() const { return tiles_x_; }
  int tiles_y() const { return tiles_y_; }
  /// Length of the arrays: that of all tiles.
  std::size_t pixels() const {
    return kTilePixels * static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y_);
  }

  /// Place of pixel (x, y) in the arrays.
  std::size_t at(int x, int y) const {
    const auto tile = static_cast<std::size_t>(y / kTile) * static_cast<std::size_t>(tiles_x_) +
                      static_cast<std::size_t>(x / kTile);
    const int block = (y & 4) / 2 + (x & 4) / 4;
    return tile * kTilePixels + static_cast<std::size_t>(block * 16 + (y & 3) * 4 + (x & 3));
  }
  /// The camera's pixel at a place in the arrays.
  std::pair<int, int> pixel(std::size_t place) const {
    const auto tiles_x = static_cast<std::size_t>(tiles_x_);
    const std::size_t tile = place / kTilePixels;
    const int block = static_cast<int>(place % kTilePixels / kBlockPixels);
    const int n = static_cast<int>(place % kBlockPixels);
    return {first_x + static_cast<int>(8 * (tile % tiles_x)) + 4 * (block & 1) + (n & 3),
            first_y + static_cast<int>(8 * (tile / tiles_x)) + 2 * (block & 2) + (n >> 2)};
  }
  bool is_hit(std::size_t place) const { return hits[place / kTilePixels] >> place % 64 & 1; }

  SurfaceSample sample(std::size_t place) const {
    if (!is_hit(place)) return {};
    return {depth_mm[place], normal_x[place], normal_y[place],
            normal_z[place], surface[place],  points.empty() ? MeshPoint{} : points[place]};
  }
  /// `sample` must be a hit.
  void set(std::size_t place, const SurfaceSample& sample) {
    hits[place / kTilePixels] |= std::uint64_t{1} << place % kTilePixels;
    depth_mm[place] = sample.depth_mm;
    normal_x[place] = sample.normal_x;
    normal_y[place] = sample.normal_y;
    normal_z[place] = sample.normal_z;
    surface[place] = sample.surface;
    if (!points.empty()) points[place] = sample.point;
  }

 private:
  int width_, height_, tiles_x_, tiles_y_;

 public:
  std::vector<std::uint64_t> hits;  ///< a word for each tile, a bit for each of its pixels
  std::vector<double> depth_mm;
  std::vector<float> normal_x, normal_y, normal_z;
  std::vector<std::int32_t> surface;
  std::vector<MeshPoint> points;       ///< empty where the scene has no mesh
  std::vector<FurtherPoints> further;  ///< for each tile; empty where no pixel can have any
  int first_x = 0, first_y = 0;        ///< the pixel of the camera that is (0, 0)
};

}  // namespace isolux
