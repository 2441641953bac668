#pragma once

#include "isolux/image/layers.h"
#include "isolux/render/lighting.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// All channels of the EXR file, as the contract's section 7 names them; no NaN in any.
Layers exr_layers(const Scene& scene, const SurfaceBuffer& buffer, const Radiance& radiance);

}  // namespace isolux
