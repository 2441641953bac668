#pragma once

#include <cstdint>
#include <vector>

namespace isolux {

/// 8-bit RGB pixels, row 0 at the top, three bytes a pixel.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

}  // namespace isolux
