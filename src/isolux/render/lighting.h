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
};

/// The terms of the reflection model for each pixel, kept apart; 0 where nothing is met.
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
/// lights is used again. Pictures and explanations both stand on this.
void light_sample(const Scene& scene, const Ray& eye_ray, const SurfaceSample& sample,
                  PixelTerms& terms);

/// Lights every pixel, on all threads.
Radiance light(const Scene& scene, const SurfaceBuffer& buffer);

}  // namespace isolux
