#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/volume/row_ranges.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include <limits>

#include "isolux/volume/row_ranges.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

template <typename T>
constexpr T kNothingLow = std::numeric_limits<T>::has_infinity ? std::numeric_limits<T>::infinity()
                                                               : std::numeric_limits<T>::max();
template <typename T>
constexpr T kNothingHigh = std::numeric_limits<T>::has_infinity
                               ? -std::numeric_limits<T>::infinity()
                               : std::numeric_limits<T>::lowest();

// `kVectors` vectors of voxels from `voxels` on: their bounds stay in registers.
template <int kVectors, class D, typename T = hn::TFromD<D>>
HWY_INLINE void range_of(D d, const T* voxels, const RowBlock& block, T* low, T* high) {
  const std::size_t lanes = hn::Lanes(d);
  hn::Vec<D> least[kVectors], greatest[kVectors];
  for (int n = 0; n < kVectors; ++n) {
    least[n] = hn::Set(d, kNothingLow<T>);
    greatest[n] = hn::Set(d, kNothingHigh<T>);
  }
  for (int slice = 0; slice < block.slices; ++slice) {
    const T* row = voxels + slice * block.slice_step;
    for (int r = 0; r < block.rows; ++r, row += block.row_step) {
      for (int n = 0; n < kVectors; ++n) {
        const hn::Vec<D> value = hn::LoadU(d, row + n * lanes);
        if constexpr (hwy::IsFloat<T>()) {
          const auto number = hn::Eq(value, value);
          least[n] = hn::Min(least[n], hn::IfThenElse(number, value, least[n]));
          greatest[n] = hn::Max(greatest[n], hn::IfThenElse(number, value, greatest[n]));
        } else {
          least[n] = hn::Min(least[n], value);
          greatest[n] = hn::Max(greatest[n], value);
        }
      }
    }
  }
  for (int n = 0; n < kVectors; ++n) {
    hn::StoreU(least[n], d, low + n * lanes);
    hn::StoreU(greatest[n], d, high + n * lanes);
  }
}

template <typename T>
void ranges(const T* voxels, std::size_t count, const RowBlock& block, T* low, T* high) {
  constexpr int kVectors = 4;  // 256 bytes at a time, which memory is good at
  const hn::ScalableTag<T> d;
  const hn::CappedTag<T, 1> one;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + kVectors * lanes <= count; i += kVectors * lanes) {
    range_of<kVectors>(d, voxels + i, block, low + i, high + i);
  }
  for (; i + lanes <= count; i += lanes) range_of<1>(d, voxels + i, block, low + i, high + i);
  if (i < count && count >= lanes) {  // once more what is left, with what was before it
    i = count - lanes;
    range_of<1>(d, voxels + i, block, low + i, high + i);
    return;
  }
  for (; i < count; ++i) range_of<1>(one, voxels + i, block, low + i, high + i);
}

void ranges_u8(const std::uint8_t* v, std::size_t n, const RowBlock& b, std::uint8_t* low,
               std::uint8_t* high) {
  ranges(v, n, b, low, high);
}
void ranges_i16(const std::int16_t* v, std::size_t n, const RowBlock& b, std::int16_t* low,
                std::int16_t* high) {
  ranges(v, n, b, low, high);
}
void ranges_u16(const std::uint16_t* v, std::size_t n, const RowBlock& b, std::uint16_t* low,
                std::uint16_t* high) {
  ranges(v, n, b, low, high);
}
void ranges_f32(const float* v, std::size_t n, const RowBlock& b, float* low, float* high) {
  ranges(v, n, b, low, high);
}

}  // namespace
}  // namespace isolux::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux {

HWY_EXPORT(ranges_u8);
HWY_EXPORT(ranges_i16);
HWY_EXPORT(ranges_u16);
HWY_EXPORT(ranges_f32);

void row_ranges(const std::uint8_t* v, int n, const RowBlock& b, std::uint8_t* low,
                std::uint8_t* high) {
  HWY_DYNAMIC_DISPATCH(ranges_u8)(v, static_cast<std::size_t>(n), b, low, high);
}
void row_ranges(const std::int16_t* v, int n, const RowBlock& b, std::int16_t* low,
                std::int16_t* high) {
  HWY_DYNAMIC_DISPATCH(ranges_i16)(v, static_cast<std::size_t>(n), b, low, high);
}
void row_ranges(const std::uint16_t* v, int n, const RowBlock& b, std::uint16_t* low,
                std::uint16_t* high) {
  HWY_DYNAMIC_DISPATCH(ranges_u16)(v, static_cast<std::size_t>(n), b, low, high);
}
void row_ranges(const float* v, int n, const RowBlock& b, float* low, float* high) {
  HWY_DYNAMIC_DISPATCH(ranges_f32)(v, static_cast<std::size_t>(n), b, low, high);
}

}  // namespace isolux
#endif
