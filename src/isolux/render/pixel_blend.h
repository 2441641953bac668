#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "isolux/render/blend_finder.h"
#include "isolux/render/blend_shares.h"
#include "isolux/render/light_spread.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/render/surface_samples.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// How the light at the points of a SurfaceBuffer is made of that at samples: a weighted mean over
/// those that lie near, on the same side, with a like normal and near the point's tangent plane.
/// Weights fall to zero smoothly, so nothing is seen of the samples' blocks.
class PixelBlend {
 public:
  enum class Detail {
    kWhole,   ///< weights at every pixel
    kSketch,  ///< at one of each block of 4 x 4, from which others take it: while the eye moves
  };

  /// Finds the weights for a buffer, on all threads.
  PixelBlend(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceSamples& samples,
             const SurfaceBuffer& buffer, Detail detail = Detail::kWhole);

  Detail detail() const { return detail_; }
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
  static constexpr std::size_t kBlock = BlendShare::kPixels;

  // The shares of consecutive tiles.
  struct Piece {
    std::vector<BlendShare> shares;
    std::vector<std::uint32_t> ends;  // of each sixteen places' shares
    std::vector<BlendWeight> points;
    std::vector<std::uint32_t> point_ends;  // of each further point's
    std::vector<std::uint32_t> tile_ends;   // of each tile's further points, in point_ends
  };

  void find_tile(const SurfaceBuffer& buffer, std::size_t tile, BlendFinder& finder, Piece& piece);
  void find_sketch(const SurfaceBuffer& buffer, std::size_t first, std::size_t last,
                   BlendFinder& finder, Piece& piece);
  void find_further(const FurtherPoints& points, BlendFinder& finder, Piece& piece);
  void number_samples(std::size_t count);
  std::size_t channels_of(const std::vector<SlopedLight>& of_samples) const;
  void spread(const std::vector<SlopedLight>& of_samples, const SurfaceBuffer& buffer,
              std::span<float* const> channels) const;

  Detail detail_;
  std::vector<Piece> pieces_;
  std::vector<std::uint32_t> samples_;
  std::optional<LightSpread> spread_;  // of a sketch
};

}  // namespace isolux
