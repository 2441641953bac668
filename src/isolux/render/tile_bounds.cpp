#include "isolux/render/tile_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Range {
  double low, high;
};

// A sphere around the block that has its centre at the origin of index space, in mm.
double block_radius(const Mat3& world_from_index) {
  double radius = 0;
  for (const double j : {-2.0, 2.0}) {
    for (const double k : {-2.0, 2.0}) {
      radius = std::max(radius, length(world_from_index * Vec3{2, j, k}));
    }
  }
  return radius;
}

}  // namespace

TileBounds::TileBounds(const SkipGrid& skip, const Affine& world_from_index, const Camera& camera,
                       int pixels)
    : tile_size(pixels), tiles_x((camera.width() + tile_size - 1) / tile_size) {
  const int tiles_y = (camera.height() + tile_size - 1) / tile_size;
  const auto count = static_cast<std::size_t>(tiles_x) * static_cast<std::size_t>(tiles_y);
  near.assign(count, kInfinity);
  far.assign(count, 0);

  const Affine camera_from_world = inverse(camera.world_from_camera());
  const Affine camera_from_index{camera_from_world.linear * world_from_index.linear,
                                 camera_from_world.point(world_from_index.offset)};
  // A rounding more than the sphere needs.
  const double radius = block_radius(world_from_index.linear) * (1 + 1e-6);
  const double pixels_per_slope = 1 / camera.pixel_size();
  const double middle_x = camera.width() / 2.0, middle_y = camera.height() / 2.0;
  const double slope_x = middle_x / pixels_per_slope, slope_y = middle_y / pixels_per_slope;

  // Where on the picture [c - radius, c + radius] can be seen, for depths of that same sphere.
  const auto seen = [&](double c, double depth) -> Range {
    if (camera.is_orthographic()) return {c - radius, c + radius};
    const double nearest = 1 / (depth - radius), farthest = 1 / (depth + radius);
    const double low = c - radius, high = c + radius;
    return {low * (low < 0 ? nearest : farthest), high * (high > 0 ? nearest : farthest)};
  };
  const auto tile_of = [&](double pixel, int tiles) {
    return static_cast<int>(
        std::clamp(std::floor(pixel / tile_size), -1.0, static_cast<double>(tiles)));
  };

  std::mutex merging;
  const std::vector<SkipGrid::Block>& blocks = skip.blocks();
  parallel_for(blocks.size(), blocks.size() / 8 + 1, [&](std::size_t begin, std::size_t end) {
    std::vector<float> nearest(count, kInfinity), farthest(count, 0);
    float nearest_everywhere = kInfinity, farthest_everywhere = 0;
    for (std::size_t n = begin; n < end; ++n) {
      const Vec3 center = camera_from_index.point(
          {4.0 * blocks[n][0] + 2, 4.0 * blocks[n][1] + 2, 4.0 * blocks[n][2] + 2});
      const double depth = -center.z;
      if (depth + radius <= 0) continue;
      const auto front = static_cast<float>(std::max(0.0, depth - radius) * (1 - 1e-6));
      const auto back = static_cast<float>((depth + radius) * (1 + 1e-6));
      if (!camera.is_orthographic() && depth - radius <= 1e-3 * radius) {
        // Beside the eye. Outside one of the picture's four sides it is not seen at all.
        const auto outside = [&](double c, double slope) {
          return std::fabs(c) - radius * std::sqrt(1 + slope * slope) > slope * depth;
        };
        if (outside(center.x, slope_x) || outside(center.y, slope_y)) continue;
        nearest_everywhere = std::min(nearest_everywhere, front);
        farthest_everywhere = std::max(farthest_everywhere, back);
        continue;
      }
      const Range x = seen(center.x, depth), y = seen(center.y, depth);
      const int left = tile_of(middle_x + x.low * pixels_per_slope, tiles_x);
      const int right = tile_of(middle_x + x.high * pixels_per_slope, tiles_x);
      const int top = tile_of(middle_y - y.high * pixels_per_slope, tiles_y);
      const int bottom = tile_of(middle_y - y.low * pixels_per_slope, tiles_y);
      for (int row = std::max(0, top); row <= std::min(tiles_y - 1, bottom); ++row) {
        const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(tiles_x);
        for (int column = std::max(0, left); column <= std::min(tiles_x - 1, right); ++column) {
          const std::size_t tile = first + static_cast<std::size_t>(column);
          nearest[tile] = std::min(nearest[tile], front);
          farthest[tile] = std::max(farthest[tile], back);
        }
      }
    }
    const std::lock_guard lock(merging);
    for (std::size_t tile = 0; tile < count; ++tile) {
      near[tile] = std::min({near[tile], nearest[tile], nearest_everywhere});
      far[tile] = std::max({far[tile], farthest[tile], farthest_everywhere});
    }
  });
}

}  // namespace isolux
