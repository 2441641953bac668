#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isolux/render/first_bounce.h"
#include "isolux/render/lighting.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// One surface that the eye ray of a pixel meets, nearest first: deeper ones are seen through it.
struct ExplainedLayer {
  std::int32_t surface = 0;
  double depth_mm = 0;
  Material material;
  double weight = 1;  ///< its share of the pixel: its opacity times what those before let through
  PointTerms terms;   ///< its own, before they are weighted
};

/// Why a pixel has its colour: what the picture knows of the surface there, and its lighting in
/// doubles, term by term. The picture itself is lit in floats, which differ from these by some 1e-6
/// at most; `radiance` and `shown` are the picture's own.
struct Explanation {
  int x = 0;
  int y = 0;
  Ray eye_ray;
  bool turned = false;  ///< whether the nearest layer's normal was turned round to face the eye
  std::vector<ExplainedLayer> layers;  ///< none: nothing is met
  std::vector<Rgb> by_bounce;          ///< of the nearest layer: the part of each bounce in E
  FirstBounce first_bounce;            ///< to the nearest layer
  Rgb mirror;                          ///< what mirrors show, weighted
  Rgb background;                      ///< what is seen of it directly, weighted
  Rgb total;
  Rgb radiance;  ///< the total as the picture has it, in 32-bit floats
  std::array<std::uint8_t, 3> shown{};

  bool is_hit() const { return !layers.empty(); }
};

/// Follows the eye ray of pixel (x, y), which must lie in the camera's picture, and lights what it
/// meets, as `render` does. With denoised indirect light all pixels are drawn for it.
Explanation explain(const Scene& scene, int x, int y);

}  // namespace isolux
