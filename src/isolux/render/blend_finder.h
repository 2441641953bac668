#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isolux/render/blend_shares.h"
#include "isolux/render/scene_surfaces.h"
#include "isolux/render/site_weights.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/render/surface_samples.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// What a sample counts at one point.
struct BlendWeight {
  std::uint32_t sample;
  float weight;
};

/// Finds which samples the light at points of a SurfaceBuffer is made of, and how much each counts:
/// those that lie near, on the same side, with a like normal and near the point's tangent plane.
class BlendFinder {
 public:
  static constexpr std::size_t kCount = BlendPoints::kCount;
  using Places = std::array<std::size_t, kCount>;

  BlendFinder(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceSamples& samples,
              const SurfaceBuffer& buffer)
      : scene_(scene), surfaces_(surfaces), samples_(samples), buffer_(buffer) {}

  /// Appends the shares at up to sixteen places, those of `mask`, all of which show a surface.
  /// Points go together where they are no further apart than `together` edges of blocks.
  void find(const Places& places, std::uint32_t mask, double together,
            std::vector<BlendShare>& shares);
  /// Appends the weights at a further point, which make 1.
  void find(const FurtherPoint& point, std::vector<BlendWeight>& weights);

 private:
  struct Met {
    Vec3 in_blocks;
    Vec3 outward;
    SeenSide side;
    std::uint32_t sheet;
  };

  Met met(std::int32_t surface, Vec3 position, Vec3 normal, Vec3 to_eye,
          const MeshPoint& point) const;
  void begin(std::int32_t surface, const Met& first);
  void set(std::size_t n, const Met& at);
  void weigh();
  void add(std::uint32_t sample, std::uint32_t lanes, const BlendPoints::Floats& weight);
  void stand_in(std::size_t n, float least);
  void share_out(std::vector<BlendShare>& shares) const;

  const Scene& scene_;
  const SceneSurfaces& surfaces_;
  const SurfaceSamples& samples_;
  const SurfaceBuffer& buffer_;
  BlendPoints points_;
  std::array<std::uint32_t, 4> of_side_;  // lanes of points that are seen from there
  std::vector<std::uint32_t> near_;
  std::vector<SiteWeights> sites_found_, samples_found_;
  BlendPoints::Floats sums_;
};

}  // namespace isolux
