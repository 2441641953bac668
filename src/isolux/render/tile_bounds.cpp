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

struct Depths {
  float near = kInfinity, far = 0;

  void include(const Depths& other) {
    near = std::min(near, other.near);
    far = std::max(far, other.far);
  }
};

// Cubes that are smaller than half of this cost more than what they tell.
constexpr double kCubePixels = 16;

// How far a cube of `half` cells to each side reaches from its centre along the axes of camera
// space, in mm; a rounding more than that.
Vec3 cube_reach(const Mat3& camera_from_index, double half) {
  Vec3 reach;
  for (int axis = 0; axis < 3; ++axis) {
    for (int column = 0; column < 3; ++column) {
      reach[axis] += half * std::fabs(camera_from_index.at(axis, column)) * (1 + 1e-6);
    }
  }
  return reach;
}

// The largest cubes that are no more than kCubePixels wide where the volume is.
int cube_level(const SkipGrid& skip, const Affine& camera_from_index, const Camera& camera) {
  const SkipGrid::Block& dims = skip.dims();
  const Vec3 half = 2.0 * Vec3{1.0 * dims[0], 1.0 * dims[1], 1.0 * dims[2]};
  const double depth =
      std::max(-camera_from_index.point(half).z, length(camera_from_index.vector(half)) / 4);
  const double pixel_mm = camera.pixel_size() * (camera.is_orthographic() ? 1 : depth);
  const Vec3 reach = cube_reach(camera_from_index.linear, 2);
  int level = 0;
  for (double pixels = 2 * std::max(reach.x, reach.y) / pixel_mm;
       2 * pixels <= kCubePixels && level + 1 < SkipGrid::kLevels; pixels *= 2) {
    ++level;
  }
  return level;
}

}  // namespace

TileBounds::TileBounds(const SkipGrid& skip, const Affine& world_from_index, const Camera& camera)
    : tiles_x((camera.width() + kPixels - 1) / kPixels) {
  const int tiles_y = (camera.height() + kPixels - 1) / kPixels;
  const auto count = static_cast<std::size_t>(tiles_x) * static_cast<std::size_t>(tiles_y);
  near.assign(count, kInfinity);
  far.assign(count, 0);

  const Affine camera_from_world = inverse(camera.world_from_camera());
  const Affine camera_from_index{camera_from_world.linear * world_from_index.linear,
                                 camera_from_world.point(world_from_index.offset)};
  const int level = cube_level(skip, camera_from_index, camera);
  const double half = SkipGrid::kBlockCells / 2 << level;
  const Vec3 reach = cube_reach(camera_from_index.linear, half);
  const double pixels_per_slope = 1 / camera.pixel_size();
  const double middle_x = camera.width() / 2.0, middle_y = camera.height() / 2.0;
  const double slope_x = middle_x / pixels_per_slope, slope_y = middle_y / pixels_per_slope;

  const auto tile_of = [&](double pixel, int tiles) {
    const double tile = std::clamp(pixel / kPixels, -1.0, static_cast<double>(tiles));
    return static_cast<int>(tile + 1) - 1;
  };

  std::mutex merging;
  const std::vector<SkipGrid::Block>& cubes = skip.cubes(level);
  parallel_for(cubes.size(), cubes.size() / 4 + 1, [&](std::size_t begin, std::size_t end) {
    std::vector<Depths> bounds(count);
    Depths everywhere;
    for (std::size_t n = begin; n < end; ++n) {
      const auto [i, j, k] = cubes[n];
      const Vec3 center =
          camera_from_index.point({half * (2 * i + 1), half * (2 * j + 1), half * (2 * k + 1)});
      const double depth = -center.z;
      if (depth + reach.z <= 0) continue;
      const auto front = static_cast<float>(std::max(0.0, depth - reach.z) * (1 - 1e-6));
      const auto back = static_cast<float>((depth + reach.z) * (1 + 1e-6));
      if (!camera.is_orthographic() && depth - reach.z <= 1e-3 * reach.z) {
        // Beside the eye. Outside one of the picture's four sides it is not seen at all.
        const auto outside = [&](double c, double wide, double slope) {
          return std::fabs(c) - wide > slope * (depth + reach.z);
        };
        if (outside(center.x, reach.x, slope_x) || outside(center.y, reach.y, slope_y)) continue;
        everywhere.include({front, back});
        continue;
      }
      // Where on the picture the cube can be seen, as slopes (orthographic: in mm).
      const double nearest_scale = camera.is_orthographic() ? 1 : 1 / (depth - reach.z);
      const double farthest_scale = camera.is_orthographic() ? 1 : 1 / (depth + reach.z);
      const auto seen = [&](double c, double wide) -> Range {
        const double low = c - wide, high = c + wide;
        return {low * (low < 0 ? nearest_scale : farthest_scale),
                high * (high > 0 ? nearest_scale : farthest_scale)};
      };
      const Range x = seen(center.x, reach.x), y = seen(center.y, reach.y);
      const int left = tile_of(middle_x + x.low * pixels_per_slope, tiles_x);
      const int right = tile_of(middle_x + x.high * pixels_per_slope, tiles_x);
      const int top = tile_of(middle_y - y.high * pixels_per_slope, tiles_y);
      const int bottom = tile_of(middle_y - y.low * pixels_per_slope, tiles_y);
      for (int row = std::max(0, top); row <= std::min(tiles_y - 1, bottom); ++row) {
        const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(tiles_x);
        for (int column = std::max(0, left); column <= std::min(tiles_x - 1, right); ++column) {
          bounds[first + static_cast<std::size_t>(column)].include({front, back});
        }
      }
    }
    const std::lock_guard lock(merging);
    for (std::size_t tile = 0; tile < count; ++tile) {
      bounds[tile].include(everywhere);
      near[tile] = std::min(near[tile], bounds[tile].near);
      far[tile] = std::max(far[tile], bounds[tile].far);
    }
  });
}

}  // namespace isolux
