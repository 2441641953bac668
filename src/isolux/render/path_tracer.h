#pragma once

#include <cstdint>
#include <vector>

#include "isolux/base/progress.h"
#include "isolux/render/indirect.h"
#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// What the paths from one point have brought so far.
struct PathSum {
  Rgb radiance;            ///< sum over samples of their estimates of E
  double square = 0;       ///< sum of the squares of the estimates' mean over the channels
  std::uint32_t open = 0;  ///< samples whose first ray met nothing
};

/// Estimates E of the contract's indirect term without bias. A path goes from a point in a
/// direction drawn by the cosine about the shading normal, and so on from what it meets, for as
/// many bounces as the scene asks for; at each point met the lamps' light is added (next-event
/// estimation), and the ambient light where a ray meets nothing. A ray passes a surface of opacity
/// A with probability 1 - A.
///
/// Random numbers are Sobol points keyed by pixel, point, bounce and the scene's seed, so results
/// depend on nothing but these; samples of a point are added up in their order.
class PathTracer {
 public:
  /// Neither argument is copied.
  PathTracer(const Scene& scene, const SceneSurfaces& surfaces);

  /// Adds samples [first, first + count) for every point of the buffer, on all threads.
  void add_samples(const SurfaceBuffer& buffer, int first, int count,
                   const ProgressListener& listener = {});
  int samples() const { return samples_; }

  /// The estimated standard error of the pixels' E, as root mean square, over their mean. Too large
  /// rather than too small: it takes samples for independent, which are better than that.
  double relative_error() const;

  Indirect indirect(const SurfaceBuffer& buffer) const;

  /// The estimated variance of each pixel's E, as the mean over its channels, [place]; too large
  /// rather than too small, as relative_error. Empty where there is one sample, which cannot tell.
  std::vector<float> variances() const;

  /// As many samples as the scene asks for.
  void run(const SurfaceBuffer& buffer, const ProgressListener& listener = {});

 private:
  class Tile;

  const Scene& scene_;
  const SceneSurfaces& surfaces_;
  int samples_ = 0;
  std::vector<PathSum> pixels_;                // [place]
  std::vector<std::vector<PathSum>> further_;  // [tile][point]
};

}  // namespace isolux
