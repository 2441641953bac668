#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "isolux/base/parallel.h"
#include "isolux/render/surface_places.h"

namespace isolux {
namespace {

// The middle of where a cell's edges cross the surface, in the cell's coordinates. `corners` are
// relative to the iso value.
std::optional<Vec3> middle_of_edges(const CellCorners& corners) {
  Vec3 sum;
  int count = 0;
  for (std::size_t from = 0; from < 8; ++from) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t to = from | std::size_t{1} << axis;
      if (to == from || (corners[from] < 0) == (corners[to] < 0)) continue;
      Vec3 crossing{static_cast<double>(from & 1), static_cast<double>(from >> 1 & 1),
                    static_cast<double>(from >> 2)};
      crossing[axis] = corners[from] / (corners[from] - corners[to]);
      sum = sum + crossing;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

// From there onto the surface, by Newton's steps along the gradient.
std::optional<Vec3> on_surface(const CellCorners& corners, Vec3 local) {
  constexpr int kSteps = 12;
  constexpr double kClose = 1e-9;  // voxels
  for (int step = 0; step < kSteps; ++step) {
    const Vec3 gradient = interpolant_gradient(corners, local);
    const double square = dot(gradient, gradient);
    if (!(square > 0)) return std::nullopt;
    const double by = interpolate(corners, local) / square;
    local = local - by * gradient;
    for (int axis = 0; axis < 3; ++axis) local[axis] = std::clamp(local[axis], 0.0, 1.0);
    if (by * by * square < kClose * kClose) return local;
  }
  return std::nullopt;
}

template <typename T>
std::optional<SurfacePlace> place_in(const VolumeView<T>& view, const IsoSurface& surface,
                                     const CellIndex& cell) {
  CellCorners corners = cell_corners(view, cell);
  for (double& corner : corners) corner -= surface.iso();
  const auto middle = middle_of_edges(corners);
  const auto local = middle ? on_surface(corners, *middle) : std::nullopt;
  if (!local) return std::nullopt;
  const auto normal = surface.normal({0, cell, *local});
  const Vec3 outward = -(surface.world_from_covector() * interpolant_gradient(corners, *local));
  if (!normal || outward == Vec3{} || !is_finite(outward)) return std::nullopt;
  const Vec3 index{cell[0] + local->x, cell[1] + local->y, cell[2] + local->z};
  return SurfacePlace{surface.volume().world_from_index.point(index),
                      as_float(*normal),
                      as_float(normalize(outward)),
                      {},
                      {}};
}

}  // namespace

std::vector<SurfacePlace> places_of(const IsoLanes& lanes, int edge) {
  constexpr int kCells = SkipGrid::kBlockCells;
  constexpr std::size_t kBlocksAPiece = 64;
  const SkipGrid& skip = lanes.skip();
  const std::size_t blocks = skip.cubes(0).size();
  std::vector<std::vector<SurfacePlace>> pieces((blocks + kBlocksAPiece - 1) / kBlocksAPiece);
  const auto find_places = [&](const auto& view, std::size_t b, std::vector<SurfacePlace>& found) {
    const SkipGrid::Block& block = skip.cubes(0)[b];
    const std::uint64_t cells = skip.cells()[skip.index(block)];
    const int parts = kCells / edge;
    for (int part = 0; part < parts * parts * parts; ++part) {
      const BlockIndex in_block{part % parts, part / parts % parts, part / (parts * parts)};
      for (int n = 0; n < edge * edge * edge; ++n) {
        const BlockIndex in_part{n % edge, n / edge % edge, n / (edge * edge)};
        CellIndex cell;
        BlockIndex at;
        int bit = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const int within = in_block[axis] * edge + in_part[axis];
          cell[axis] = block[axis] * kCells + within;
          at[axis] = block[axis] * parts + in_block[axis];
          bit += within << (2 * axis);
        }
        if (!(cells >> bit & 1)) continue;
        if (auto place = place_in(view, lanes.surface(), cell)) {
          place->block = at;
          found.push_back(*place);
        }
      }
    }
  };
  visit_voxels(lanes.surface().volume(), [&](const auto& view) {
    parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t piece = begin; piece < end; ++piece) {
        const std::size_t last = std::min(blocks, (piece + 1) * kBlocksAPiece);
        for (std::size_t b = piece * kBlocksAPiece; b < last; ++b) {
          find_places(view, b, pieces[piece]);
        }
      }
    });
  });
  std::vector<SurfacePlace> places;
  for (const auto& piece : pieces) places.insert(places.end(), piece.begin(), piece.end());
  return places;
}

}  // namespace isolux
