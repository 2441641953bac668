#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isolux/render/blend_shares.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/render/surface_samples.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// How the light at the points of a SurfaceBuffer is made of that at samples: a weighted mean over
/// those that lie near, on the same side, with a like normal and near the point's tangent plane.
/// Weights fall to zero smoothly, so nothing is seen of the samples' blocks.
class PixelBlend {
 public:
  /// Finds the weights for a buffer, on all threads.
  PixelBlend(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceSamples& samples,
             const SurfaceBuffer& buffer);

  /// Numbers of all samples that have a weight, in order.
  const std::vector<std::uint32_t>& samples() const { return samples_; }

  /// `of_samples` are in the order of samples(), with one channel for each, which then is every
  /// channel of the answer, or as many as that has.
  /// The light at the pixels of the buffer, into arrays of its length; 0 where nothing is met.
  void pixels(const std::vector<SlopedLight>& of_samples, const SurfaceBuffer& buffer,
              std::span<float* const> channels) const;
  /// The light at each further point of each tile; 0 for the background.
  std::vector<std::vector<std::array<float, 3>>> further(const std::vector<SlopedLight>& of_samples,
                                                         const SurfaceBuffer& buffer) const;

  double bytes() const;

 private:
  static constexpr int kBlock = BlendShare::kPixels;

  struct Point {
    std::uint32_t sample;
    float weight;
  };
  // The shares of consecutive tiles.
  struct Piece {
    std::vector<BlendShare> shares;
    std::vector<std::uint32_t> ends;  // of each block's shares, four for each tile
    std::vector<Point> points;
    std::vector<std::uint32_t> point_ends;  // of each further point's
    std::vector<std::uint32_t> tile_ends;   // of each tile's further points, in point_ends
  };
  class Finder;

  std::size_t channels_of(const std::vector<SlopedLight>& of_samples) const;

  std::vector<Piece> pieces_;
  std::vector<std::uint32_t> samples_;
};

}  // namespace isolux
