#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// A place that sends light to a point: what lies about it within a fifth of its distance counts
/// as one.
struct Sender {
  Vec3 position;  ///< mm, on the surface
  std::int32_t surface = 0;
  double share = 0;  ///< of all that the first bounce brings, as the mean of the channels
};

/// Where the first bounce of indirect light comes from.
struct FirstBounce {
  double light = 0;             ///< E_1, as the mean of the channels
  std::vector<Sender> senders;  ///< the brightest first, eight at most
  double sky_share = 0;         ///< of all that the first bounce brings
};

/// Looks from the point that a pixel of the buffer shows along 2048 rays by the cosine, the same
/// for every pixel and every machine. Light and shares are therefore estimates, right to some
/// percent.
FirstBounce first_bounce(const Scene& scene, const SceneSurfaces& surfaces,
                         const SurfaceBuffer& buffer, std::size_t place);

}  // namespace isolux
