#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "isolux/render/blend_shares.h"
#include "isolux/render/indirect.h"
#include "isolux/render/link_sums.h"
#include "isolux/render/link_tracer.h"
#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/render/surface_samples.h"
#include "isolux/scene/camera.h"

namespace isolux {

/// The light that the points of a picture receive from what is close to them. Samples cannot tell
/// it, for it changes within a cell, where facets meet; so each pixel has links of its own for it,
/// to what short rays from it meet. What is further away is blended of samples and counts by the
/// share of directions in which nothing is close, so that all shares go on making 1.
class CloseLight {
 public:
  /// For a picture that is blended of samples of the set `from`. `close`: the share of what these
  /// see that is close, for each place in the buffer; where it is 0 there is nothing to find. Keeps
  /// references to all but these two last.
  CloseLight(const LinkTracer& tracer, const SceneSurfaces& surfaces, const SurfaceSamples& from,
             const SurfaceBuffer& buffer, const Camera& camera, std::vector<float> close);

  /// Shoots the rays that are missing. Asks `stop` in between. Returns whether there are all.
  bool shoot(const std::function<bool()>& stop = {});
  bool is_whole() const { return shot_ == tiles_.size(); }
  /// How much of that is done, in [0, 1].
  double done() const;
  /// All rays that there will be.
  double rays() const { return rays_; }

  /// Calls body(sample) for what links lead to, for some more than once.
  template <typename Body>
  void each_sender(const Body& body) const {
    for (const Tile& tile : tiles_) {
      for (const CloseLink& link : tile.links) body(link.to);
    }
  }

  /// Adds what samples send, where `pixels` has what comes from further away.
  void add(const SentLight& sent, RgbLayer& pixels) const;
  /// Lets the open sky count as all that is further away does.
  void dim_sky(std::vector<float>& sky) const;

  double bytes() const;

 private:
  struct CloseLink {
    std::uint32_t to;
    float share;
  };
  struct Tile {
    std::vector<CloseLink> links;
    std::vector<float> further;       // what blended light counts, for each pixel; none: all of it
    std::vector<std::uint16_t> ends;  // of each pixel's links
  };
  class Shooter;

  std::size_t rays_of(float close) const;

  const SceneSurfaces& surfaces_;
  const SurfaceSamples& from_;
  const SurfaceBuffer& buffer_;
  const LinkTracer& tracer_;
  Camera camera_;
  std::vector<float> close_;
  std::vector<Vec3> directions_;  // in the tangent frame; see Shooter
  std::vector<Tile> tiles_;
  std::size_t shot_ = 0;  // tiles
  double rays_ = 0;
  int halvings_ = 0;  // of each pixel's
};

}  // namespace isolux
