#pragma once

#include <string>
#include <string_view>

#include "isolux/image/picture.h"

namespace isolux {

/// The bytes of a JPEG file, made for speed: for pictures that are gone in the next moment.
/// `quality` from 1 to 100.
std::string encode_jpeg(const Picture& picture, int quality);

/// Reads a JPEG file's bytes as 8-bit RGB. `name` is for errors.
/// @throws WorkError  where they are damaged, are no JPEG, or are too many for memory.
Picture decode_jpeg(std::string_view bytes, const std::string& name);

}  // namespace isolux
