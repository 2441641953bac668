#pragma once

#include <string>
#include <string_view>

#include "isolux/image/metadata.h"
#include "isolux/image/picture.h"

namespace isolux {

enum class PngEffort {
  kSmall,  ///< for files
  kFast,   ///< for pictures that are sent at once: a few times faster, a little larger
};

/// The bytes of a PNG file: 8-bit RGB, no alpha, the metadata as iTXt chunks in order of their
/// keys. `is_srgb` adds the sRGB chunk. The same bytes for the same arguments.
std::string encode_png(const Picture& picture, const Metadata& metadata, bool is_srgb,
                       PngEffort effort = PngEffort::kSmall);

struct DecodedPng {
  Picture picture;
  Metadata metadata;
};

/// Reads a PNG file's bytes back, as 8-bit RGB. `name` is for errors.
/// @throws WorkError  where they are damaged or are no PNG.
DecodedPng decode_png(std::string_view bytes, const std::string& name);

}  // namespace isolux
