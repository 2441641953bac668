#pragma once

#include <hwy/aligned_allocator.h>

#include <cstddef>
#include <span>

#include "isolux/scene/camera.h"

// What denoise.cpp says to the code for each instruction set (denoise_lanes.cpp).

namespace isolux::denoising {

/// What a level is smoothed by, in steps from a pixel: the middle of the B3 spline's 5 x 5. What is
/// left out would weigh 14 %.
struct Tap {
  int dx, dy;
  float weight;
};
constexpr Tap kTaps[] = {{0, 0, 36.0f / 220},                          //
                         {-1, 0, 24.0f / 220},  {1, 0, 24.0f / 220},   //
                         {0, -1, 24.0f / 220},  {0, 1, 24.0f / 220},   //
                         {-1, -1, 16.0f / 220}, {1, -1, 16.0f / 220},  //
                         {-1, 1, 16.0f / 220},  {1, 1, 16.0f / 220},   //
                         {-2, 0, 6.0f / 220},   {2, 0, 6.0f / 220},    //
                         {0, -2, 6.0f / 220},   {0, 2, 6.0f / 220}};
constexpr int kTapCount = static_cast<int>(sizeof kTaps / sizeof *kTaps);

/// Level n + 1 is level n smoothed by taps 2^n pixels apart.
constexpr int kLevels = 5;
constexpr int kMargin = 2 << (kLevels - 1);  ///< what taps reach, in pixels
/// What a vector may reach beyond the end of a row; rows begin at multiples of it.
constexpr int kMostLanes = 16;

/// Rows of floats with margins on all sides, which stay as they were made.
class Plane {
 public:
  Plane(int width, int height, float value = 0);

  float* row(int y) { return values_.get() + offset(y); }
  const float* row(int y) const { return values_.get() + offset(y); }
  std::ptrdiff_t stride() const { return stride_; }

 private:
  std::ptrdiff_t offset(int y) const { return (y + kMargin) * stride_ + kMargin; }

  std::ptrdiff_t stride_;
  hwy::AlignedFreeUniquePtr<float[]> values_;
};

struct Colors {
  Plane r, g, b;

  Colors(int width, int height) : r(width, height), g(width, height), b(width, height) {}
  Plane& at(int c) { return c == 0 ? r : c == 1 ? g : b; }
  const Plane& at(int c) const { return c == 0 ? r : c == 1 ? g : b; }
};

/// What tells which pixels may be smoothed into each other.
struct Guide {
  static constexpr float kNothing = -1e4f;  ///< the key where no surface is met
  static constexpr float kApart = 4;        ///< more than normals can differ by

  int width, height;
  Plane key;  ///< n.x + kApart * surface number
  Plane normal_y, normal_z;
  Plane depth;  ///< mm from the eye's plane; 1 where no surface is met

  Guide(int w, int h)
      : width(w), height(h), key(w, h, kNothing), normal_y(w, h), normal_z(w, h), depth(w, h, 1) {}
};

/// The eye rays, in floats: the direction of pixel (x, y) is first + x * along_x + y * along_y;
/// its origin moves by along_x and along_y where there is no perspective.
struct Rays {
  bool is_orthographic;
  float first[3], along_x[3], along_y[3];
  float pixel_size;  ///< mm; with perspective at 1 mm from the eye

  explicit Rays(const Camera& camera);
};

/// Of white noise of variance 1 on an endless wall.
struct Gains {
  float taps;         ///< sum of the squares of the taps' weights
  float correlation;  ///< the variance of the next level over that of this one times `taps`
  float detail;       ///< the variance of the detail over what the next level has lost of it
};

/// Makes level n + 1 of level n, and takes out of the result the noise in the detail between levels
/// n - 1 and n. What is null is not there: in the first pass that detail, in the last the next
/// level.
struct Pass {
  const Guide* guide;
  const Rays* rays;
  int step;  ///< pixels between taps
  Gains gains;
  float strength;         ///< how many times its variance noise is taken for
  bool has_variance;      ///< of level 0; else all of the finest detail is taken for noise
  const Colors* level;    ///< n
  Colors* before;         ///< level n - 1, which the next level then takes the place of
  const Plane* variance;  ///< of the mean over the channels
  const Plane* energy;    ///< of the detail before: the square of the mean over its channels
  const Plane* noise;     ///< and what noise makes of it
  Plane* next_variance;
  Plane* next_energy;
  Plane* next_noise;
  const Colors* result_before;
  Colors* result;
};

/// Some of the rows.
void filter(const Pass& pass, std::span<const int> rows);

/// Makes depths out of distances along rows [begin, end).
void flatten(const Rays& rays, Guide& guide, int begin, int end);

}  // namespace isolux::denoising
