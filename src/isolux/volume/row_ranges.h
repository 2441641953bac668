#pragma once

#include <cstddef>
#include <cstdint>

namespace isolux {

/// The rows of a box of voxels: `rows` of them a `row_step` apart in each of `slices`, a
/// `slice_step` apart; steps count voxels.
struct RowBlock {
  int rows;
  int slices;
  std::ptrdiff_t row_step;
  std::ptrdiff_t slice_step;
};

/// For each i in [0, count), the least and the greatest of voxels[i] over all rows of the block, at
/// memory speed. NaN is left out; where there is nothing else, the type's greatest and least value
/// (infinities for floats).
void row_ranges(const std::uint8_t* voxels, int count, const RowBlock& block, std::uint8_t* low,
                std::uint8_t* high);
void row_ranges(const std::int16_t* voxels, int count, const RowBlock& block, std::int16_t* low,
                std::int16_t* high);
void row_ranges(const std::uint16_t* voxels, int count, const RowBlock& block, std::uint16_t* low,
                std::uint16_t* high);
void row_ranges(const float* voxels, int count, const RowBlock& block, float* low, float* high);

}  // namespace isolux
