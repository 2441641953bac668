#pragma once

#include <vector>

#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"
#include "isolux/shade/reflection.h"

namespace isolux {

/// Radiance in three float channels.
struct RgbLayer {
  std::vector<float> r, g, b;

  explicit RgbLayer(std::size_t pixels) : r(pixels), g(pixels), b(pixels) {}
  /// Rounds to floats. Not inline: where g++ 12 sees doubles made floats and doubles again, it
  /// forgets the rounding of the first two of three (a fault in its vectorizer).
  void set(std::size_t pixel, Rgb value);
  Rgb at(std::size_t pixel) const { return {r[pixel], g[pixel], b[pixel]}; }
  float* channel(int c) { return (c == 0 ? r : c == 1 ? g : b).data(); }
};

/// The terms of the reflection model for each pixel, kept apart, in the order of a SurfaceBuffer; 0
/// where nothing is met.
struct Radiance {
  RgbLayer ambient;
  RgbLayer diffuse;
  RgbLayer specular;
  RgbLayer total;  ///< their sum; the background where nothing is met

  explicit Radiance(std::size_t pixels)
      : ambient(pixels), diffuse(pixels), specular(pixels), total(pixels) {}
};

/// The terms of one pixel, before they are rounded to floats.
struct PixelTerms {
  SurfacePoint point;
  Rgb ambient;
  std::vector<LightTerms> lights;
  Rgb diffuse;   ///< sum over lights
  Rgb specular;  ///< sum over lights
  Rgb total;
};

/// Lights the surface that one eye ray has met (`sample.is_hit()`), into `terms`, whose list of
/// lights is used again. Explanations tell these numbers; pictures have them from `relight`, which
/// does the same in lanes of floats.
void light_sample(const Scene& scene, const Ray& eye_ray, const SurfaceSample& sample,
                  PixelTerms& terms);

}  // namespace isolux
