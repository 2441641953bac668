#pragma once

#include <string>

#include "isolux/image/layers.h"
#include "isolux/image/metadata.h"
#include "isolux/render/indirect.h"
#include "isolux/render/lighting.h"
#include "isolux/render/shadows.h"
#include "isolux/render/surface_buffer.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// All channels of the EXR file, as the contract's section 7 names them; no NaN in any.
Layers exr_layers(const Scene& scene, const SurfaceBuffer& buffer, const Radiance& radiance,
                  const Indirect& indirect = {});

/// The bytes of a PNG file of the displayed picture, or of an EXR file of all layers.
std::string encode_picture(const Scene& scene, const SurfaceBuffer& buffer, const Shadows& shadows,
                           const Indirect& indirect, const Metadata& metadata, bool is_exr);

/// @throws WorkError  where drawing such a picture takes more memory than is allowed.
void check_picture_memory(const SceneDescription& scene, bool is_exr);

}  // namespace isolux
