#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "isolux/render/surface_buffer.h"

namespace isolux {

/// One channel of the light at a sample, and what it gains towards points whose normals are a
/// little different: at a point with normal n it is mean + n.x slope[0] + n.y slope[1] + n.z
/// slope[2].
struct SlopedLight {
  float mean;
  std::array<float, 3> slope;
};

/// A sample's weights in the pixels of a block, in 1 / kWhole: those of a pixel make kWhole.
struct BlendShare {
  static constexpr int kPixels = SurfaceBuffer::kBlockPixels;
  static constexpr int kWhole = 65535;

  std::uint32_t sample;  ///< where it stands among those that count
  std::array<std::uint16_t, kPixels> weight;
};

/// The light at the pixels of a block, in lanes. `of_samples`: for each sample as many channels as
/// `to` has, 1 or 3. `normals`: x, y and z, and `to`: a channel each, of all pixels of the block.
/// Where no share has a weight the light is 0, and the normal may be anything.
void blend(std::span<const BlendShare> shares, const SlopedLight* of_samples,
           const std::array<const float*, 3>& normals, std::span<float* const> to);
/// The same plainly.
void blend_plainly(std::span<const BlendShare> shares, const SlopedLight* of_samples,
                   const std::array<const float*, 3>& normals, std::span<float* const> to);

}  // namespace isolux
