#pragma once

#include <optional>

#include "isolux/base/vec3.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/camera.h"

namespace isolux {

/// A part of a picture, in shares of its width and height from the upper left corner.
struct PicturePart {
  double left = 0, top = 0, right = 0, bottom = 0;
};

/// The smallest part that holds every pixel in which a surface is met; nothing where none is.
std::optional<PicturePart> seen_part(const SurfaceBuffer& buffer);

/// Of what the picture shows, the point nearest to `place`, or a neighbour of it: a pixel of each
/// tile is looked at, and all those round the best of them. Nothing where no surface is met.
std::optional<Vec3> nearest_seen(const Camera& camera, const SurfaceBuffer& buffer, Vec3 place);

}  // namespace isolux
