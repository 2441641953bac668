#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "isolux/base/vec3.h"

namespace isolux {

/// What one eye ray meets first, as precisely as a SurfaceBuffer keeps it.
struct SurfaceSample {
  static constexpr std::int32_t kNothing = -1;

  double depth_mm = std::numeric_limits<double>::infinity();  ///< along the eye ray
  float normal_x = 0;  ///< unit, world space, turned towards the eye; 0 where nothing is met
  float normal_y = 0;
  float normal_z = 0;
  std::int32_t surface = kNothing;  ///< place in Scene::surfaces

  bool is_hit() const { return surface != kNothing; }
  Vec3 normal() const { return {normal_x, normal_y, normal_z}; }
};

/// For each pixel, what the eye ray meets first, and nothing of light: distance, shading normal and
/// surface number. The position is the camera's ray at that distance, to the precision of doubles.
struct SurfaceBuffer {
  int width = 0;
  int height = 0;
  std::vector<double> depth_mm;
  std::vector<float> normal_x, normal_y, normal_z;
  std::vector<std::int32_t> surface;

  SurfaceBuffer(int w, int h) : width(w), height(h) {
    const std::size_t pixels = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    const SurfaceSample nothing;
    depth_mm.assign(pixels, nothing.depth_mm);
    normal_x.assign(pixels, nothing.normal_x);
    normal_y.assign(pixels, nothing.normal_y);
    normal_z.assign(pixels, nothing.normal_z);
    surface.assign(pixels, nothing.surface);
  }

  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
  SurfaceSample sample(std::size_t pixel) const {
    return {depth_mm[pixel], normal_x[pixel], normal_y[pixel], normal_z[pixel], surface[pixel]};
  }
  void set(std::size_t pixel, const SurfaceSample& sample) {
    depth_mm[pixel] = sample.depth_mm;
    normal_x[pixel] = sample.normal_x;
    normal_y[pixel] = sample.normal_y;
    normal_z[pixel] = sample.normal_z;
    surface[pixel] = sample.surface;
  }
};

}  // namespace isolux
