#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "isolux/render/blend_shares.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// Light at one pixel of each block of 4 x 4, spread over the others: a mean over the nine blocks
/// around that falls with the distance in pixels, with the eighth power of the cosine between
/// normals, and with the distance from the tangent plane. It is as smooth as these pixels lie
/// dense, and serves while the eye moves.
class LightSpread {
 public:
  /// A block's pixel.
  struct Point {
    std::int32_t surface = kNone;
    float x, y;  ///< the pixel
    Vec3f position, normal;
    float plane_scale;  ///< 1 / the square of the distance from its tangent plane that is too far
  };
  static constexpr std::int32_t kNone = -1;

  /// `thickness_mm`: what is too far for each surface.
  LightSpread(const Camera& camera, const SurfaceBuffer& buffer,
              const std::vector<double>& thickness_mm);

  /// The place of the pixel that stands for a block, one near its middle; nothing where no pixel of
  /// it shows a surface.
  static std::optional<std::size_t> place(const SurfaceBuffer& buffer, std::size_t tile,
                                          std::size_t block);

  /// Lights the pixels of a tile. `of_points`: for each block of each tile as many channels as `to`
  /// has, 1 or 3.
  void light(const SurfaceBuffer& buffer, std::size_t tile, const SlopedLight* of_points,
             std::span<float* const> to) const;

 private:
  RayFan fan_;  // from the eye
  bool is_orthographic_;
  std::vector<Point> points_;  // [tile * 4 + block]
};

/// 1 / the square of the distance in pixels over which light is spread: less than to the pixels of
/// blocks that are not beside a block.
constexpr double kSpreadScale = 1 / (5.5 * 5.5);
/// What a block's own point counts at least in its pixels.
constexpr double kLeastSpread = 1e-6;

/// A block of 4 x 4 pixels, and the points that light it.
struct SpreadBlock {
  static constexpr std::size_t kMost = 9;

  std::size_t place;  ///< of its first pixel in the buffer
  float x, y;         ///< that pixel
  int count = 0;      ///< of points, the block's own first
  const LightSpread::Point* points[kMost];
  const SlopedLight* lights[kMost];  ///< each with as many channels as are lit
};

/// Lights the pixels of a block, in lanes. `fan`: rays from the eye.
void spread_light(const SpreadBlock& block, const SurfaceBuffer& buffer, const RayFan& fan,
                  bool is_orthographic, std::span<float* const> to);
/// The same plainly.
void spread_light_plainly(const SpreadBlock& block, const SurfaceBuffer& buffer, const RayFan& fan,
                          bool is_orthographic, std::span<float* const> to);

}  // namespace isolux
