#include "isolux/intersect/rasteriser.h"

#include <memory>
#include <utility>

#include "isolux/base/parallel.h"
#include "isolux/intersect/raster_lanes.h"
#include "isolux/intersect/triangle_setup.h"

namespace isolux {
namespace {

using namespace raster;

constexpr std::size_t kChunk = 1 << 14;  // triangles that are sorted into tiles together

std::vector<Projected> projected(const Mesh& mesh, const Projection& projection) {
  std::vector<Projected> vertices(mesh.positions.size());
  parallel_for(vertices.size(), 1 << 13, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) vertices[n] = projection(mesh.positions[n]);
  });
  return vertices;
}

class Raster {
 public:
  Raster(const Mesh& mesh, const PixelRays& rays)
      : triangles_(mesh.triangles.size()),
        projection_(rays),
        vertices_(projected(mesh, projection_)),
        view_{&projection_, mesh.triangles.data(), vertices_.data()},
        buffer_(rays.width, rays.height) {}

  RasterBuffer run() {
    find_all_candidates();
    sort_into_tiles();
    std::vector<std::size_t> filled;
    for (std::size_t tile = 0; tile < buffer_.tile_count(); ++tile) {
      if (tile_begin_[tile] < tile_begin_[tile + 1]) filled.push_back(tile);
    }
    buffer_.keep_tiles(filled);
    parallel_for(filled.size(), 1, [&](std::size_t begin, std::size_t end) {
      TileBuffer tile;
      for (std::size_t n = begin; n < end; ++n) draw_tile(filled[n], tile);
    });
    return std::move(buffer_);
  }

 private:
  std::size_t chunk_count() const { return (triangles_ + kChunk - 1) / kChunk; }

  void find_all_candidates() {
    found_.resize(chunk_count());
    parallel_for(found_.size(), 1, [&](std::size_t begin, std::size_t end) {
      const auto room = std::make_unique_for_overwrite<Candidate[]>(kChunk);
      for (std::size_t chunk = begin; chunk < end; ++chunk) {
        const std::size_t first = chunk * kChunk, last = std::min(triangles_, first + kChunk);
        const std::size_t count = find_candidates(view_, first, last, room.get());
        found_[chunk].assign(room.get(), room.get() + count);
      }
    });
  }

  // Calls use(tile, candidate) for every tile in which a candidate of a chunk may have pixels.
  template <typename Use>
  void for_each_tile(std::size_t chunk, const Use& use) const {
    for (const Candidate& c : found_[chunk]) {
      for (int ty = c.y0 / kTile; ty <= c.y1 / kTile; ++ty) {
        for (int tx = c.x0 / kTile; tx <= c.x1 / kTile; ++tx) {
          use(static_cast<std::size_t>(ty) * static_cast<std::size_t>(buffer_.tiles_x()) +
                  static_cast<std::size_t>(tx),
              c);
        }
      }
    }
  }

  // Counts, adds up, fills: each chunk of triangles has its own stretch of each tile's list, so
  // the lists are in order whoever fills them.
  void sort_into_tiles() {
    const std::size_t tiles = buffer_.tile_count(), chunks = chunk_count();
    std::vector<std::size_t> next(chunks * tiles);
    const auto for_each_chunk = [&](const auto& use) {
      parallel_for(chunks, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t chunk = begin; chunk < end; ++chunk) {
          std::size_t* of_chunk = next.data() + chunk * tiles;
          for_each_tile(chunk, [&](std::size_t tile, const Candidate& candidate) {
            use(of_chunk[tile], candidate);
          });
        }
      });
    };
    for_each_chunk([](std::size_t& count, const Candidate&) { ++count; });
    tile_begin_.resize(tiles + 1);
    std::size_t total = 0;
    for (std::size_t tile = 0; tile < tiles; ++tile) {
      tile_begin_[tile] = total;
      for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
        total += std::exchange(next[chunk * tiles + tile], total);
      }
    }
    tile_begin_[tiles] = total;
    in_tiles_ = std::make_unique_for_overwrite<Candidate[]>(total);
    for_each_chunk(
        [&](std::size_t& place, const Candidate& candidate) { in_tiles_[place++] = candidate; });
  }

  void draw_tile(std::size_t number, TileBuffer& tile) {
    const int x0 = static_cast<int>(number) % buffer_.tiles_x() * kTile;
    const int y0 = static_cast<int>(number) / buffer_.tiles_x() * kTile;
    const PixelBox area{x0, y0, std::min(x0 + kTile, projection_.width()) - 1,
                        std::min(y0 + kTile, projection_.height()) - 1};
    std::ranges::fill(tile.nearness, -std::numeric_limits<double>::infinity());
    std::ranges::fill(tile.triangle, std::uint64_t{RasterBuffer::kNothing});
    const std::size_t first = tile_begin_[number];
    draw_candidates(view_, in_tiles_.get() + first, tile_begin_[number + 1] - first, area, tile);
    std::uint32_t* to = buffer_.tile(number);
    for (int y = 0; y < kTile; ++y) {
      const std::uint64_t* row = tile.triangle + y * TileBuffer::kRow;
      to = std::transform(row, row + kTile, to,
                          [](std::uint64_t n) { return static_cast<std::uint32_t>(n); });
    }
  }

  std::size_t triangles_;
  Projection projection_;
  std::vector<Projected> vertices_;
  View view_;
  std::vector<std::vector<Candidate>> found_;  ///< by chunk
  std::vector<std::size_t> tile_begin_;
  std::unique_ptr<Candidate[]> in_tiles_;  ///< tile after tile
  RasterBuffer buffer_;
};

}  // namespace

void RasterBuffer::keep_tiles(const std::vector<std::size_t>& tiles) {
  for (std::uint32_t n = 0; n < tiles.size(); ++n) place_[tiles[n]] = n;
  triangles_ = std::make_unique_for_overwrite<std::uint32_t[]>(kPixels * tiles.size());
}

RasterBuffer rasterise(const Mesh& mesh, const PixelRays& rays) { return Raster(mesh, rays).run(); }

std::vector<std::uint32_t> rasterise_plainly(const Mesh& mesh, const PixelRays& rays) {
  const Projection projection(rays);
  const std::vector<Projected> vertices = projected(mesh, projection);
  const View view{&projection, mesh.triangles.data(), vertices.data()};
  const auto pixels = static_cast<std::size_t>(rays.width) * static_cast<std::size_t>(rays.height);
  std::vector<std::uint32_t> nearest_triangle(pixels, RasterBuffer::kNothing);
  std::vector<double> nearest(pixels, -std::numeric_limits<double>::infinity());
  for (std::uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
    const auto corners = corners_of(view, triangle);
    const PixelBox box = projection.box(corners);
    const TriangleFunctions functions(corners, projection.is_orthographic());
    if (functions.is_empty) continue;
    for (int y = box.y0; y <= box.y1; ++y) {
      for (int x = box.x0; x <= box.x1; ++x) {
        const double nearness = functions.nearness.at(x, y);
        const auto at = static_cast<std::size_t>(y) * static_cast<std::size_t>(rays.width) +
                        static_cast<std::size_t>(x);
        if (!functions.covers(x, y) || !(nearness > nearest[at])) continue;
        if (projection.is_orthographic() && nearness >= 0) continue;  // behind the eye's plane
        nearest[at] = nearness;
        nearest_triangle[at] = triangle;
      }
    }
  }
  return nearest_triangle;
}

}  // namespace isolux
