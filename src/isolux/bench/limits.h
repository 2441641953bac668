#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "isolux/render/surface_buffer.h"
#include "isolux/volume/volume.h"

// What memory alone allows, by plain loops on all threads: no work that touches the same bytes can
// be faster by much.

namespace isolux {

/// Reads every voxel once; the sum of their bytes, taken as 64-bit words.
std::uint64_t read_voxels_once(const Volume& volume);

/// Reads as many bytes as a surface buffer holds for the pixels that are hit, and writes an 8-bit
/// RGB picture of its size.
class RelightingLimit {
 public:
  RelightingLimit(const SurfaceBuffer& buffer, std::size_t hit_pixels);
  void run();

 private:
  std::vector<std::uint64_t> read_;
  std::vector<std::uint8_t> written_;
};

}  // namespace isolux
