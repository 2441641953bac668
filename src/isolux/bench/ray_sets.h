#pragma once

#include <string>
#include <vector>

#include "isolux/base/ray.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/camera.h"

// Rays that start at what a picture shows: one for each pixel that is hit, from half a millimetre
// above the surface. So far off, a mesh of the surface lies behind as well, and the same rays can
// be given to a peer. They come in blocks of 4x4 pixels, so that neighbours can go in one packet.

namespace isolux {

/// Into the hemisphere over the surface, as likely as the cosine to its normal: the rays of
/// indirect light. The same ones for the same picture.
std::vector<Ray> cosine_rays(const Camera& camera, const SurfaceBuffer& buffer);

/// Towards a lamp outside the volume, so that a shadow falls wherever anything is met.
std::vector<Ray> shadow_rays(const Camera& camera, const SurfaceBuffer& buffer, Vec3 lamp);

/// Writes six 32-bit floats a ray: origin and direction. @throws WorkError
void write_rays(const std::string& path, const std::vector<Ray>& rays);
/// Reads them back. @throws WorkError
std::vector<Ray> read_rays(const std::string& path);

}  // namespace isolux
