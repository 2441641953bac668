#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "isolux/image/picture.h"
#include "isolux/render/session.h"

namespace isolux {

/// What a viewer can show in place of the picture.
enum class ShownLayer {
  kPicture,
  kDirect,
  kAmbient,
  kDiffuse,
  kSpecular,
  kMirror,
  kIndirect,
  kCosTheta,
  kCosPhi,
  kNormal,
  kDepth
};

/// All of them with their names: "picture", "ambient", "diffuse", ...
std::span<const std::pair<std::string_view, ShownLayer>> shown_layers();

std::optional<ShownLayer> shown_layer_named(std::string_view name);

/// How to read false colours: evenly spaced colours from the value `low` to the value `high`.
struct Legend {
  double low = 0;
  double high = 0;
  std::string unit;
  std::vector<std::array<std::uint8_t, 3>> colors;
};

struct ShownPicture {
  Picture picture;
  std::optional<Legend> legend;  ///< of cosines and depth
};

/// "direct" is the picture without ambient and indirect light, what lamps send straight. Terms pass
/// the scene's display; normals are shown as (n + 1) / 2, cosines (of lamp number `light` in the
/// scene, not clamped) and depth in false colours. Where nothing is met: the displayed background.
ShownPicture show_layer(ShownLayer layer, const Scene& scene, std::size_t light, Session& session);

}  // namespace isolux
