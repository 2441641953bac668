#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/intersect/surface_cells.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "isolux/intersect/surface_cells.h"
#include "isolux/volume/brick_grid.h"

#ifndef ISOLUX_INTERSECT_SURFACE_CELLS_ROWS
#define ISOLUX_INTERSECT_SURFACE_CELLS_ROWS
namespace isolux {

// A brick's rows of voxels along i. A row's word has a bit for each voxel: at or above the
// threshold from bit 0 on, at or below it from bit 16 on.
template <typename T>
struct BrickRows {
  static constexpr int kRow = 9;  ///< voxels that 8 cells touch

  const T* first;
  std::ptrdiff_t row_step, slice_step;
  int voxels, rows, slices;  ///< at most kRow, less at the volume's border
  bool may_read_16;          ///< voxels from the beginning of any row
};

}  // namespace isolux
#endif

HWY_BEFORE_NAMESPACE();
namespace isolux::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Whether all voxels are finite; else the words are not all there.
template <typename T>
bool row_words(const BrickRows<T>& brick, const Threshold<T>& threshold, std::uint32_t* words) {
  const hn::CappedTag<T, 16> d;
  const auto at_least = hn::Set(d, threshold.at_least), at_most = hn::Set(d, threshold.at_most);
  const std::size_t lanes = hn::Lanes(d);
  bool is_finite = true;
  for (int slice = 0; slice < brick.slices; ++slice) {
    const T* row = brick.first + slice * brick.slice_step;
    for (int r = 0; r < brick.rows; ++r, row += brick.row_step) {
      std::uint32_t above = 0, below = 0;
      for (std::size_t i = 0; i < BrickRows<T>::kRow; i += lanes) {
        const auto value = hn::LoadU(d, row + i);
        std::uint8_t bits[2][8] = {};
        hn::StoreMaskBits(d, hn::Not(hn::Lt(value, at_least)), bits[0]);
        hn::StoreMaskBits(d, hn::Not(hn::Gt(value, at_most)), bits[1]);
        above |= static_cast<std::uint32_t>(bits[0][0] | bits[0][1] << 8) << i;
        below |= static_cast<std::uint32_t>(bits[1][0] | bits[1][1] << 8) << i;
      }
      const std::uint32_t there = (1u << brick.voxels) - 1;
      words[slice * BrickRows<T>::kRow + r] = (above & there) | (below & there) << 16;
      if constexpr (hwy::IsFloat<T>()) {
        for (int i = 0; i < brick.voxels; ++i) is_finite &= std::isfinite(row[i]);
      }
    }
  }
  return is_finite;
}

bool words_u8(const BrickRows<std::uint8_t>& b, const Threshold<std::uint8_t>& t,
              std::uint32_t* words) {
  return row_words(b, t, words);
}
bool words_i16(const BrickRows<std::int16_t>& b, const Threshold<std::int16_t>& t,
               std::uint32_t* words) {
  return row_words(b, t, words);
}
bool words_u16(const BrickRows<std::uint16_t>& b, const Threshold<std::uint16_t>& t,
               std::uint32_t* words) {
  return row_words(b, t, words);
}
bool words_f32(const BrickRows<float>& b, const Threshold<float>& t, std::uint32_t* words) {
  return row_words(b, t, words);
}

}  // namespace
}  // namespace isolux::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux {
namespace {

HWY_EXPORT(words_u8);
HWY_EXPORT(words_i16);
HWY_EXPORT(words_u16);
HWY_EXPORT(words_f32);

constexpr int kRow = 9;
using RowWords = std::array<std::uint32_t, kRow * kRow>;

template <typename T>
bool words_in_lanes(const BrickRows<T>& brick, const Threshold<T>& threshold, RowWords& words) {
  if (!brick.may_read_16) return false;
  if constexpr (std::is_same_v<T, std::uint8_t>) {
    return HWY_DYNAMIC_DISPATCH(words_u8)(brick, threshold, words.data());
  } else if constexpr (std::is_same_v<T, std::int16_t>) {
    return HWY_DYNAMIC_DISPATCH(words_i16)(brick, threshold, words.data());
  } else if constexpr (std::is_same_v<T, std::uint16_t>) {
    return HWY_DYNAMIC_DISPATCH(words_u16)(brick, threshold, words.data());
  } else {
    return HWY_DYNAMIC_DISPATCH(words_f32)(brick, threshold, words.data());
  }
}

// The same voxel by voxel, where it also sees what is not finite: `wild` has a bit for each.
template <typename T>
void words_plainly(const BrickRows<T>& brick, const Threshold<T>& threshold, RowWords& words,
                   RowWords& wild) {
  for (int slice = 0; slice < brick.slices; ++slice) {
    for (int r = 0; r < brick.rows; ++r) {
      const T* row = brick.first + slice * brick.slice_step + r * brick.row_step;
      std::uint32_t word = 0, not_finite = 0;
      for (int i = 0; i < brick.voxels; ++i) {
        word |= static_cast<std::uint32_t>(row[i] >= threshold.at_least) << i;
        word |= static_cast<std::uint32_t>(row[i] <= threshold.at_most) << (16 + i);
        if constexpr (std::is_floating_point_v<T>) {
          not_finite |= static_cast<std::uint32_t>(!std::isfinite(row[i])) << i;
        }
      }
      words[static_cast<std::size_t>(slice * kRow + r)] = word;
      wild[static_cast<std::size_t>(slice * kRow + r)] = not_finite;
    }
  }
}

// For the cells of a row: the bits of all their corners, each cell's at its lowest corner.
std::uint32_t corners(const RowWords& words, int y, int z) {
  const std::size_t at = static_cast<std::size_t>(z * kRow + y);
  const std::uint32_t edges = words[at] | words[at + 1] | words[at + kRow] | words[at + kRow + 1];
  return edges | edges >> 1;
}

}  // namespace

template <typename T>
Threshold<T>::Threshold(double iso) {
  if constexpr (std::is_integral_v<T>) {
    at_least = static_cast<T>(std::ceil(iso));
    at_most = static_cast<T>(std::floor(iso));
  } else {
    const T near = static_cast<T>(iso);
    constexpr T kInfinity = std::numeric_limits<T>::infinity();
    at_least = near >= iso ? near : std::nextafter(near, kInfinity);
    at_most = near <= iso ? near : std::nextafter(near, -kInfinity);
  }
}

template <typename T>
BrickCells surface_cells(const VolumeView<T>& view, const std::array<int, 3>& brick,
                         const Threshold<T>& threshold) {
  constexpr int kCells = BrickGrid::kCells;
  static_assert(kCells == kRow - 1);
  const std::array<int, 3> first{brick[0] * kCells, brick[1] * kCells, brick[2] * kCells};
  const auto count = [&](std::size_t axis) {
    return std::min(kRow, view.dims[axis] - first[axis]);
  };
  const int voxels = count(0), rows = count(1), slices = count(2);
  const std::size_t last_row = view.offset(first[0], first[1] + rows - 1, first[2] + slices - 1);
  const BrickRows<T> box{view.voxels + view.offset(first[0], first[1], first[2]),
                         view.dims[0],
                         static_cast<std::ptrdiff_t>(view.offset(0, 0, 1)),
                         voxels,
                         rows,
                         slices,
                         last_row + 16 <= view.offset(0, 0, view.dims[2])};
  RowWords words, wild{};
  if (!words_in_lanes(box, threshold, words)) words_plainly(box, threshold, words, wild);

  BrickCells cells{};
  const std::uint32_t there = (1u << (voxels - 1)) - 1;
  for (int z = 0; z + 1 < slices; ++z) {
    for (int y = 0; y + 1 < rows; ++y) {
      const std::uint32_t both = corners(words, y, z);
      const std::uint64_t row = both & both >> 16 & ~corners(wild, y, z) & there;
      const std::size_t block = static_cast<std::size_t>((y >> 2) * 2 + (z >> 2) * 4);
      const int shift = (y & 3) * 4 + (z & 3) * 16;
      cells[block] |= (row & 15) << shift;
      cells[block + 1] |= (row >> 4) << shift;
    }
  }
  return cells;
}

template struct Threshold<std::uint8_t>;
template struct Threshold<std::int16_t>;
template struct Threshold<std::uint16_t>;
template struct Threshold<float>;
template BrickCells surface_cells(const VolumeView<std::uint8_t>&, const std::array<int, 3>&,
                                  const Threshold<std::uint8_t>&);
template BrickCells surface_cells(const VolumeView<std::int16_t>&, const std::array<int, 3>&,
                                  const Threshold<std::int16_t>&);
template BrickCells surface_cells(const VolumeView<std::uint16_t>&, const std::array<int, 3>&,
                                  const Threshold<std::uint16_t>&);
template BrickCells surface_cells(const VolumeView<float>&, const std::array<int, 3>&,
                                  const Threshold<float>&);

}  // namespace isolux
#endif
