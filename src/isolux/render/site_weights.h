#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isolux/render/blend_shares.h"
#include "isolux/render/surface_samples.h"

namespace isolux {

/// Points that are near to each other, on one surface and sheet: in those lanes that `mask` has.
/// The others are as one of these.
struct BlendPoints {
  static constexpr std::size_t kCount = BlendShare::kPixels;
  using Floats = std::array<float, kCount>;

  std::uint32_t mask = 0;
  std::int32_t surface = 0;
  std::uint32_t sheet = 0;
  Vec3 origin;                          // in blocks
  Floats x, y, z;                       // in blocks, from `origin`
  Floats normal_x, normal_y, normal_z;  // outside
  Floats across_x, across_y, across_z;  // the same as a covector in blocks
};

/// What a site, or a sample of it, counts in points.
struct SiteWeights {
  std::uint32_t which;
  std::uint32_t lanes;         ///< in which it counts
  BlendPoints::Floats weight;  ///< in these; in others anything
};

/// How far samples are blended, in edges of blocks.
constexpr float kBlendReach = 1.75f;
/// How far from a point's tangent plane they may lie, in the same. On another sheet of a mesh
/// hardly at all: where two of them lie in one plane, the seam is not seen.
inline float blend_thickness(const SampleSite& site, const BlendPoints& points) {
  return site.sheet == points.sheet ? 0.5f : 0.02f;
}

/// The weights of those of some sites' outsides that count anywhere, without regard to points'
/// sides, in lanes. They fall to zero with distance, with the eighth power of the cosine between
/// normals, and with the distance from the tangent plane.
void weigh_sites(const BlendPoints& points, const SampleSite* sites,
                 std::span<const std::uint32_t> which, std::vector<SiteWeights>& to);
/// The same plainly.
void weigh_sites_plainly(const BlendPoints& points, const SampleSite* sites,
                         std::span<const std::uint32_t> which, std::vector<SiteWeights>& to);

}  // namespace isolux
