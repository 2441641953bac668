#pragma once

#include <string>

#include "isolux/image/picture.h"

namespace isolux {

/// The bytes of a JPEG file, made for speed: for pictures that are gone in the next moment.
/// `quality` from 1 to 100.
std::string encode_jpeg(const Picture& picture, int quality);

}  // namespace isolux
