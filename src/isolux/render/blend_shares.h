#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "isolux/render/surface_buffer.h"

namespace isolux {

/// Four numbers of a sample: irradiance per channel and the share of open sky.
using SampleLight = std::array<float, 4>;

/// The light at a sample, and what it gains towards points whose normals are a little different:
/// at a point with normal n it is mean + n.x slope[0] + n.y slope[1] + n.z slope[2].
struct SlopedLight {
  SampleLight mean;
  std::array<SampleLight, 3> slope;
};

/// A sample's weights in the pixels of a block, in 1 / kWhole: those of a pixel make kWhole.
struct BlendShare {
  static constexpr int kPixels = SurfaceBuffer::kBlockPixels;
  static constexpr int kWhole = 65535;

  std::uint32_t sample;  ///< where it stands among those that count
  std::array<std::uint16_t, kPixels> weight;
};

/// The light at the pixels of a block, in lanes. `normals`: x, y and z, and `to`: a number of
/// SampleLight each, of all pixels of the block. Where no share has a weight the light is 0, and
/// the normal may be anything.
void blend(std::span<const BlendShare> shares, const SlopedLight* of_samples,
           const std::array<const float*, 3>& normals, float* const (&to)[4]);
/// The same plainly.
void blend_plainly(std::span<const BlendShare> shares, const SlopedLight* of_samples,
                   const std::array<const float*, 3>& normals, float* const (&to)[4]);

}  // namespace isolux
