#pragma once

#include <cstdint>

#include "isolux/intersect/triangle_setup.h"
#include "isolux/mesh/mesh.h"

// What rasteriser.cpp and the code for each instruction set say to each other.

namespace isolux::raster {

constexpr int kTile = RasterBuffer::kTile;

/// A triangle that may have a pixel's centre, and the pixels it may have, both ends included.
struct Candidate {
  std::uint32_t triangle;
  std::uint16_t x0, y0, x1, y1;
};

/// The mesh and its vertices as the picture sees them.
struct View {
  const Projection* projection;
  const Mesh::Triangle* triangles;
  const Projected* vertices;
};

inline std::array<Projected, 3> corners_of(const View& view, std::uint32_t triangle) {
  const Mesh::Triangle& t = view.triangles[triangle];
  return {view.vertices[t[0]], view.vertices[t[1]], view.vertices[t[2]]};
}

/// `box` must not be empty.
inline Candidate candidate(std::uint32_t triangle, const PixelBox& box) {
  const auto pixel = [](int n) { return static_cast<std::uint16_t>(n); };
  return {triangle, pixel(box.x0), pixel(box.y0), pixel(box.x1), pixel(box.y1)};
}

/// A tile's depth buffer. Rows are longer than the tile, so that a vector may reach beyond its end.
struct TileBuffer {
  static constexpr int kRow = kTile + 8;

  alignas(64) double nearness[kTile * kRow];
  alignas(64) std::uint64_t triangle[kTile * kRow];
};

/// Finds the candidates among triangles [begin, end), in their order; writes them to `to`, which
/// has room for all. How many there are.
std::size_t find_candidates(const View& view, std::size_t begin, std::size_t end, Candidate* to);

/// Draws candidates, in their order, over what is in the buffer. `area` is the tile's part of the
/// picture.
void draw_candidates(const View& view, const Candidate* candidates, std::size_t count,
                     const PixelBox& area, TileBuffer& buffer);

}  // namespace isolux::raster
