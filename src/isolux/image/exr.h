#pragma once

#include <string>
#include <string_view>

#include "isolux/image/layers.h"
#include "isolux/image/metadata.h"

namespace isolux {

/// The bytes of an OpenEXR file: one part, scan lines, ZIP, 32-bit float; the metadata as string
/// attributes. The same bytes for the same arguments.
std::string encode_exr(const Layers& layers, const Metadata& metadata);

struct DecodedExr {
  Layers layers;
  Metadata metadata;
};

/// Reads an EXR file's bytes back. `name` is for errors.
/// @throws WorkError  where they are damaged or are no EXR.
DecodedExr decode_exr(std::string_view bytes, const std::string& name);

}  // namespace isolux
