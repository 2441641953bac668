#pragma once

#include "isolux/base/rgb.h"

namespace isolux {

/// How a surface answers light, per colour channel; every coefficient and the opacity lie in [0,
/// 1].
struct Material {
  Rgb ka{.1, .1, .1};     ///< ambient
  Rgb kd{.8, .8, .8};     ///< diffuse (Lambert)
  Rgb ks{.3, .3, .3};     ///< specular (Phong)
  double shininess = 40;  ///< Phong's exponent, >= 0; the mirror direction only as it grows
  Rgb kr{0, 0, 0};        ///< mirror
  double opacity = 1;     ///< how much of what lies behind is hidden

  bool operator==(const Material&) const = default;
};

}  // namespace isolux
