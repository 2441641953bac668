#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "isolux/render/lighting.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// Why a pixel has its colour: what the picture knows of the surface there, and its lighting in
/// doubles, term by term. The picture itself is lit in floats, which differ from these by some 1e-6
/// at most; `radiance` and `shown` are the picture's own.
struct Explanation {
  int x = 0;
  int y = 0;
  Ray eye_ray;
  SurfaceSample sample;  ///< nothing met: the rest, but for `radiance` and `shown`, is empty
  bool turned = false;   ///< whether the normal was turned round to face the eye
  PixelTerms terms;
  Rgb radiance;  ///< the total as the picture has it, in 32-bit floats, or the background
  std::array<std::uint8_t, 3> shown{};
};

/// Follows the eye ray of pixel (x, y), which must lie in the camera's picture, and lights what it
/// meets, as `render` does.
Explanation explain(const Scene& scene, int x, int y);

}  // namespace isolux
