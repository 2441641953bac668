#include "isolux/intersect/rasteriser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "isolux/base/mat3.h"
#include "isolux/base/parallel.h"
#include "isolux/intersect/ray_triangle.h"

namespace isolux {
namespace {

constexpr int kTile = 32;                // pixels along an edge
constexpr std::size_t kChunk = 1 << 14;  // triangles that are sorted into tiles together

// A vertex as the picture sees it.
struct Projected {
  Vec3 q;       ///< homogeneous: the pixel (q.x / q.z, q.y / q.z) where q.z > 0
  double x, y;  ///< that pixel
  double depth;
};

struct PixelBox {
  int x0, y0, x1, y1;  ///< both included; x1 < x0 or y1 < y0: empty

  bool is_empty() const { return x1 < x0 || y1 < y0; }
};

// Maps positions to pixels: the inverse of the rays.
class Projection {
 public:
  explicit Projection(const PixelRays& rays)
      : orthographic_(rays.direction.along_x == Vec3{} && rays.direction.along_y == Vec3{}),
        origin_(rays.origin.first),
        width_(rays.width),
        height_(rays.height) {
    const PixelRays::Plane& plane = orthographic_ ? rays.origin : rays.direction;
    to_pixel_ = inverse(Mat3{{plane.along_x, plane.along_y, rays.direction.first}});
  }

  Projected operator()(Vec3f position) const {
    const Vec3 q = to_pixel_ * (as_double(position) - origin_);
    if (orthographic_) return {{q.x, q.y, 1}, q.x, q.y, q.z};
    const double scale = 1 / q.z;
    return {q, q.x * scale, q.y * scale, q.z};
  }

  /// The pixels whose centres the triangle may cover. Where it passes the eye's plane, what is in
  /// front of it counts, down to a millionth of its depth.
  PixelBox box(const std::array<Projected, 3>& corners) const {
    Bounds bounds;
    double greatest = 0, least = std::numeric_limits<double>::infinity();
    for (const Projected& corner : corners) {
      greatest = std::max(greatest, corner.depth);
      least = std::min(least, corner.depth);
    }
    if (!(greatest > 0)) return {0, 0, -1, -1};
    if (orthographic_ || least > 0) {
      for (const Projected& corner : corners) bounds.add(corner.x, corner.y);
    } else {
      const double nearest = 1e-6 * greatest;
      for (std::size_t n = 0; n < 3; ++n) {
        const Vec3 p = corners[n].q, r = corners[(n + 1) % 3].q;
        if (p.z > nearest) bounds.add(corners[n].x, corners[n].y);
        if ((p.z > nearest) == (r.z > nearest)) continue;
        const Vec3 cut = p + (nearest - p.z) / (r.z - p.z) * (r - p);
        bounds.add(cut.x / nearest, cut.y / nearest);
      }
    }
    return {first_pixel(bounds.low_x), first_pixel(bounds.low_y), last_pixel(bounds.high_x, width_),
            last_pixel(bounds.high_y, height_)};
  }

  bool is_orthographic() const { return orthographic_; }

 private:
  struct Bounds {
    double low_x = kFar, low_y = kFar, high_x = -kFar, high_y = -kFar;

    void add(double x, double y) {
      low_x = std::min(low_x, x);
      low_y = std::min(low_y, y);
      high_x = std::max(high_x, x);
      high_y = std::max(high_y, y);
    }
  };
  // A hair further out, for rounding.
  static int first_pixel(double low) {
    return static_cast<int>(std::max(0.0, std::ceil(std::min(low, kFar) - kHair)));
  }
  static int last_pixel(double high, int count) {
    return static_cast<int>(std::min(count - 1.0, std::floor(std::max(high, -kFar) + kHair)));
  }

  static constexpr double kFar = 1e9, kHair = 1e-6;
  bool orthographic_;
  Vec3 origin_;
  Mat3 to_pixel_;
  int width_, height_;
};

// A linear function of the pixel.
struct Linear {
  double x = 0, y = 0, constant = 0;

  double at(int px, int py) const { return (x * px + y * py) + constant; }
};

// The functions that decide a triangle's pixels. Antisymmetric: with corners p and q exchanged an
// edge's numbers change their sign and nothing else.
struct TriangleFunctions {
  std::array<Linear, 3> edges;  ///< >= 0 inside; 0 only where `owns_zero`
  std::array<bool, 3> owns_zero;
  Linear nearness;  ///< grows towards the eye
  bool is_empty = false;

  TriangleFunctions(const std::array<Projected, 3>& c, bool orthographic) {
    const double area = dot(c[0].q, cross(c[1].q, c[2].q));
    const double sign = area < 0 ? -1 : 1;
    if (area == 0 || !std::isfinite(area)) {
      is_empty = true;
      return;
    }
    const double per_area = 1 / std::fabs(area);
    for (std::size_t n = 0; n < 3; ++n) {
      const Vec3 e = sign * cross(c[(n + 1) % 3].q, c[(n + 2) % 3].q);
      edges[n] = {e.x, e.y, e.z};
      owns_zero[n] = e.x > 0 || (e.x == 0 && e.y > 0);
      // Perspective: the edge functions together are |area| / t. Orthographic: t is the corners'
      // depths blended by them.
      const double share = orthographic ? -c[n].depth * per_area : per_area;
      nearness.x += share * e.x;
      nearness.y += share * e.y;
      nearness.constant += share * e.z;
    }
  }

  bool covers(int x, int y) const {
    for (std::size_t n = 0; n < 3; ++n) {
      const double value = edges[n].at(x, y);
      if (value < 0 || (value == 0 && !owns_zero[n])) return false;
    }
    return true;
  }
};

// A tile's depth buffer.
struct TileBuffer {
  std::array<double, kTile * kTile> nearness;
  std::array<std::uint32_t, kTile * kTile> triangle;
};

class Raster {
 public:
  Raster(const Mesh& mesh, const PixelRays& rays)
      : mesh_(mesh),
        rays_(rays),
        projection_(rays),
        tiles_x_((rays.width + kTile - 1) / kTile),
        tiles_y_((rays.height + kTile - 1) / kTile) {}

  RasterBuffer run() {
    project();
    sort_into_tiles();
    const std::size_t pixels =
        static_cast<std::size_t>(rays_.width) * static_cast<std::size_t>(rays_.height);
    buffer_.width = rays_.width;
    buffer_.height = rays_.height;
    buffer_.triangle.resize(pixels);
    buffer_.t.resize(pixels);
    buffer_.u.resize(pixels);
    buffer_.v.resize(pixels);
    parallel_for(tile_count(), 1, [&](std::size_t begin, std::size_t end) {
      TileBuffer tile;
      for (std::size_t n = begin; n < end; ++n) draw_tile(n, tile);
    });
    return std::move(buffer_);
  }

 private:
  std::size_t tile_count() const {
    return static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y_);
  }

  void project() {
    projected_.resize(mesh_.positions.size());
    parallel_for(projected_.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) projected_[n] = projection_(mesh_.positions[n]);
    });
  }

  std::array<Projected, 3> projected_corners(std::uint32_t triangle) const {
    const Mesh::Triangle& t = mesh_.triangles[triangle];
    return {projected_[t[0]], projected_[t[1]], projected_[t[2]]};
  }

  template <typename Use>
  void for_each_tile_of(std::uint32_t triangle, const Use& use) const {
    const PixelBox box = projection_.box(projected_corners(triangle));
    if (box.is_empty()) return;
    for (int ty = box.y0 / kTile; ty <= box.y1 / kTile; ++ty) {
      for (int tx = box.x0 / kTile; tx <= box.x1 / kTile; ++tx) {
        use(static_cast<std::size_t>(ty) * static_cast<std::size_t>(tiles_x_) +
            static_cast<std::size_t>(tx));
      }
    }
  }

  // Counts, adds up, fills: each chunk of triangles has its own stretch of each tile's list, so
  // the lists are in order whoever fills them.
  void sort_into_tiles() {
    const std::size_t triangles = mesh_.triangles.size(), tiles = tile_count();
    const std::size_t chunks = (triangles + kChunk - 1) / kChunk;
    std::vector<std::size_t> next(chunks * tiles);
    const auto for_each_chunk = [&](const auto& use) {
      parallel_for(chunks, 1, [&](std::size_t begin, std::size_t) {
        const std::size_t end = std::min(triangles, (begin + 1) * kChunk);
        for (std::size_t t = begin * kChunk; t < end; ++t) {
          const auto triangle = static_cast<std::uint32_t>(t);
          for_each_tile_of(triangle,
                           [&](std::size_t tile) { use(next[begin * tiles + tile], triangle); });
        }
      });
    };
    for_each_chunk([](std::size_t& count, std::uint32_t) { ++count; });
    tile_begin_.resize(tiles + 1);
    std::size_t total = 0;
    for (std::size_t tile = 0; tile < tiles; ++tile) {
      tile_begin_[tile] = total;
      for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
        total += std::exchange(next[chunk * tiles + tile], total);
      }
    }
    tile_begin_[tiles] = total;
    in_tiles_.resize(total);
    for_each_chunk(
        [&](std::size_t& place, std::uint32_t triangle) { in_tiles_[place++] = triangle; });
  }

  void draw_tile(std::size_t number, TileBuffer& tile) {
    const int x0 = static_cast<int>(number) % tiles_x_ * kTile;
    const int y0 = static_cast<int>(number) / tiles_x_ * kTile;
    const PixelBox area{x0, y0, std::min(x0 + kTile, rays_.width) - 1,
                        std::min(y0 + kTile, rays_.height) - 1};
    tile.nearness.fill(-std::numeric_limits<double>::infinity());
    tile.triangle.fill(RasterBuffer::kNothing);
    for (std::size_t n = tile_begin_[number]; n < tile_begin_[number + 1]; ++n) {
      draw_triangle(in_tiles_[n], area, tile);
    }
    for (int y = area.y0; y <= area.y1; ++y) {
      for (int x = area.x0; x <= area.x1; ++x) {
        finish(x, y, tile.triangle[static_cast<std::size_t>((y - y0) * kTile + x - x0)]);
      }
    }
  }

  void draw_triangle(std::uint32_t triangle, const PixelBox& area, TileBuffer& tile) const {
    const std::array<Projected, 3> c = projected_corners(triangle);
    const PixelBox box = projection_.box(c);
    const TriangleFunctions functions(c, projection_.is_orthographic());
    if (functions.is_empty) return;
    for (int y = std::max(box.y0, area.y0); y <= std::min(box.y1, area.y1); ++y) {
      for (int x = std::max(box.x0, area.x0); x <= std::min(box.x1, area.x1); ++x) {
        if (!functions.covers(x, y)) continue;
        const double nearness = functions.nearness.at(x, y);
        const auto at = static_cast<std::size_t>((y - area.y0) * kTile + x - area.x0);
        if (!(nearness > tile.nearness[at])) continue;
        if (projection_.is_orthographic() && nearness >= 0) continue;  // behind the eye's plane
        tile.nearness[at] = nearness;
        tile.triangle[at] = triangle;
      }
    }
  }

  // The pixel's numbers are those that a ray gets from this triangle.
  void finish(int x, int y, std::uint32_t triangle) {
    const std::size_t at = buffer_.at(x, y);
    buffer_.triangle[at] = triangle;
    if (triangle == RasterBuffer::kNothing) return;
    const RayTriangles ray({rays_.origin.at(x, y), rays_.direction.at(x, y)});
    const auto [t, u, v] = ray.in_plane(corners(mesh_, mesh_.triangles[triangle]));
    if (!std::isfinite(t)) {  // the ray runs in its plane
      buffer_.triangle[at] = RasterBuffer::kNothing;
      return;
    }
    buffer_.t[at] = t;
    buffer_.u[at] = static_cast<float>(u);
    buffer_.v[at] = static_cast<float>(v);
  }

  const Mesh& mesh_;
  const PixelRays& rays_;
  Projection projection_;
  int tiles_x_, tiles_y_;
  std::vector<Projected> projected_;
  std::vector<std::size_t> tile_begin_;
  std::vector<std::uint32_t> in_tiles_;  ///< triangles, tile after tile
  RasterBuffer buffer_;
};

}  // namespace

RasterBuffer rasterise(const Mesh& mesh, const PixelRays& rays) { return Raster(mesh, rays).run(); }

}  // namespace isolux
