#pragma once

#include <cstddef>

#include "isolux/io/stored_voxels.h"

namespace isolux {

/// How a DICOM file packs one number a voxel, in this machine's byte order.
struct PixelPacking {
  int bits_allocated =
      16;  ///< 1, 8, 16 or 32, of floats 32 or 64; single bits lie lowest first, without gaps
  int bits_stored = 16;  ///< at most bits_allocated
  int high_bit = 15;     ///< the stored bits' highest
  bool is_signed = false;
  bool is_float = false;
  bool operator==(const PixelPacking&) const = default;
};

/// Unpacks voxels [first, first + count) of `packed` into `voxels` with the rescaling; bits above
/// and below the stored ones are left out. Voxel is one of Volume's types.
/// @return false where a whole-number type cannot hold a value exactly; the voxels are then
/// worthless. For floats always true; `rounds` is set where one had to be rounded.
template <typename Voxel>
bool unpack(const PixelPacking& packing, const void* packed, std::size_t first, std::size_t count,
            const Rescale& rescale, Voxel* voxels, bool& rounds);

}  // namespace isolux
