#pragma once

#include <array>
#include <optional>
#include <vector>

#include "isolux/render/lighting.h"

namespace isolux {

/// Indirect light at the points of a SurfaceBuffer: E_B of the contract's reflection model, whose
/// product with kd takes the place of the ambient term. Empty where the scene asks for none.
struct Indirect {
  RgbLayer pixels{0};                                      ///< E, [place in the buffer]
  std::vector<std::vector<std::array<float, 3>>> further;  ///< E, [tile][point]
  std::vector<float> sky;  ///< share of open sky, by the cosine, [place in the buffer]

  bool empty() const { return sky.empty(); }
  std::optional<Rgb> of_pixel(std::size_t place) const {
    return empty() ? std::nullopt : std::optional(pixels.at(place));
  }
  std::optional<Rgb> of_further(std::size_t tile, std::size_t point) const {
    if (empty()) return std::nullopt;
    const auto& [r, g, b] = further[tile][point];
    return Rgb{r, g, b};
  }
};

}  // namespace isolux
