// The voxels around the cells of a vector of lanes. Compiled once for each instruction set, so
// guarded as Highway asks.
#if defined(ISOLUX_INTERSECT_LANE_VOXELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOLUX_INTERSECT_LANE_VOXELS_INL_H_
#undef ISOLUX_INTERSECT_LANE_VOXELS_INL_H_
#else
#define ISOLUX_INTERSECT_LANE_VOXELS_INL_H_
#endif

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <bit>

#include "isolux/intersect/lane_vectors-inl.h"
#include "isolux/intersect/lane_walk.h"

#if HWY_TARGET != HWY_SCALAR
HWY_BEFORE_NAMESPACE();
namespace isolux::lanes::HWY_NAMESPACE {
// Asks for rows of voxels beside the lowest corners of cells, `rows` and `slices` further on, so
// that they are there when they are read.
template <typename T, std::size_t kRows>
HWY_INLINE void fetch_rows(const Field& field, const VI (&cell)[3], std::uint32_t lanes,
                           const std::int8_t (&rows)[kRows][2]) {
  alignas(64) std::int32_t at[3][RayLanes::kCount];
  for (int a = 0; a < 3; ++a) hn::Store(cell[a], kI, at[a]);
  const std::ptrdiff_t row = field.dims[0], slice = row * field.dims[1];
  for (; lanes != 0; lanes &= lanes - 1) {
    const int n = std::countr_zero(lanes);
    const T* corner =
        static_cast<const T*>(field.voxels) + at[0][n] + row * at[1][n] + slice * at[2][n];
    for (const auto& [y, z] : rows) hwy::Prefetch(corner + y * row + z * slice);
  }
}
constexpr std::int8_t kCornerRows[4][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
// Those that only the normal needs.
constexpr std::int8_t kRowsAround[8][2] = {{-1, 0}, {-1, 1}, {2, 0}, {2, 1},
                                           {0, -1}, {1, -1}, {0, 2}, {1, 2}};

// Reads voxels of type T relative to the lowest corner of each lane's cell; relative to that of
// cell (spare, spare, spare) where a lane is not asked for.
template <typename T, bool kWide>
class Voxels {
 public:
  HWY_INLINE Voxels(const Field& field, const VI (&cell)[3], MI lanes, std::int32_t spare)
      : voxels_(static_cast<const T*>(field.voxels)),
        row_(field.dims[0]),
        slice_(static_cast<std::ptrdiff_t>(field.dims[0]) * field.dims[1]) {
    if constexpr (kWide) {
      alignas(64) std::int32_t at[3][RayLanes::kCount];
      for (int a = 0; a < 3; ++a) {
        hn::Store(hn::IfThenElse(lanes, cell[a], hn::Set(kI, spare)), kI, at[a]);
      }
      for (std::size_t n = 0; n < hn::Lanes(kI); ++n) {
        wide_[n] = at[0][n] + row_ * at[1][n] + slice_ * at[2][n];
      }
    } else {
      const VI rows = hn::Add(cell[1], hn::Mul(cell[2], hn::Set(kI, field.dims[1])));
      const VI offset = hn::Add(cell[0], hn::Mul(rows, hn::Set(kI, field.dims[0])));
      const auto otherwise = static_cast<std::int32_t>(spare * (1 + row_ + slice_));
      bytes_ = hn::Mul(hn::IfThenElse(lanes, offset, hn::Set(kI, otherwise)),
                       hn::Set(kI, static_cast<std::int32_t>(sizeof(T))));
    }
  }

  // Corner (x, y, z) at x + 2 y + 4 z.
  HWY_INLINE void corners(VF (&c)[8]) const {
    pair(0, c[0], c[1]);
    pair(row_, c[2], c[3]);
    pair(slice_, c[4], c[5]);
    pair(slice_ + row_, c[6], c[7]);
  }

  // The trilinear blend at `p` of the central differences at the corners, and what its largest
  // term is made of. With q(-1), q(0), q(1), q(2) the bilinear blends of four parallel planes, its
  // part along their normal is ((1 - p) (q(1) - q(-1)) + p (q(2) - q(0))) / 2.
  HWY_INLINE void gradient(const VF (&p)[3], VF (&g)[3], VF& spread) const {
    VF v[4][4];  // [row][x + 1]; rows (y, z) = 00 10 01 11
    for (int row = 0; row < 4; ++row) four((row & 1) * row_ + (row >> 1) * slice_, v[row]);
    VF planes[4];
    for (int x = 0; x < 4; ++x) {
      planes[x] = bilinear(v[0][x], v[1][x], v[2][x], v[3][x], p[1], p[2]);
    }
    g[0] = difference(planes, p[0], spread);

    VF ends[4][2];  // [y][z], blended along x
    for (int z = 0; z < 2; ++z) {
      ends[0][z] = blended_pair(z * slice_ - row_, p[0]);
      ends[1][z] = blend(v[2 * z][1], v[2 * z][2], p[0]);
      ends[2][z] = blend(v[2 * z + 1][1], v[2 * z + 1][2], p[0]);
      ends[3][z] = blended_pair(z * slice_ + 2 * row_, p[0]);
    }
    for (int y = 0; y < 4; ++y) planes[y] = blend(ends[y][0], ends[y][1], p[2]);
    g[1] = difference(planes, p[1], spread);

    planes[0] = blend(blended_pair(-slice_, p[0]), blended_pair(row_ - slice_, p[0]), p[1]);
    planes[1] = blend(ends[1][0], ends[2][0], p[1]);
    planes[2] = blend(ends[1][1], ends[2][1], p[1]);
    planes[3] = blend(blended_pair(2 * slice_, p[0]), blended_pair(2 * slice_ + row_, p[0]), p[1]);
    g[2] = difference(planes, p[2], spread);
  }

 private:
  static HWY_INLINE VF blend(VF a, VF b, VF w) { return hn::MulAdd(w, hn::Sub(b, a), a); }
  static HWY_INLINE VF bilinear(VF a, VF b, VF c, VF d, VF x, VF y) {
    return blend(blend(a, b, x), blend(c, d, x), y);
  }
  static HWY_INLINE VF difference(const VF (&q)[4], VF w, VF& spread) {
    const VF low = hn::Sub(q[2], q[0]), high = hn::Sub(q[3], q[1]);
    spread = hn::Max(spread, hn::Max(hn::Abs(low), hn::Abs(high)));
    return hn::Mul(hn::Set(kF, 0.5f), blend(low, high, w));
  }
  HWY_INLINE VF blended_pair(std::ptrdiff_t at, VF w) const {
    VF a, b;
    pair(at, a, b);
    return blend(a, b, w);
  }

  // The voxels at x = 0 and 1 of the row that begins `at` voxels from the cell's lowest corner.
  HWY_INLINE void pair(std::ptrdiff_t at, VF& a, VF& b) const {
    if constexpr (kWide) {
      each(at, a);
      each(at + 1, b);
    } else if constexpr (sizeof(T) == 4) {
      a = hn::GatherOffset(kF, voxels_ + at, bytes_);
      b = hn::GatherOffset(kF, voxels_ + at + 1, bytes_);
    } else if constexpr (sizeof(T) == 2) {
      split(gather(at, bytes_), a, b);
    } else {
      // Four bytes that end with the two, so that none lies past the last voxel; or begin with
      // them, at the very first.
      const VI two = hn::Set(kI, 2);
      const VI back = hn::Min(hn::Add(bytes_, hn::Set(kI, static_cast<std::int32_t>(at))), two);
      const VI bytes = hn::Shr(gather(at, hn::Sub(bytes_, back)), hn::ShiftLeft<3>(back));
      a = hn::ConvertTo(kF, hn::And(bytes, hn::Set(kI, 255)));
      b = hn::ConvertTo(kF, hn::And(hn::ShiftRight<8>(bytes), hn::Set(kI, 255)));
    }
  }

  // The voxels at x = -1, 0, 1, 2.
  HWY_INLINE void four(std::ptrdiff_t at, VF (&v)[4]) const {
    if constexpr (sizeof(T) == 1 && !kWide) {
      const VI bytes = gather(at - 1, bytes_);
      v[0] = hn::ConvertTo(kF, hn::And(bytes, hn::Set(kI, 255)));
      v[1] = hn::ConvertTo(kF, hn::And(hn::ShiftRight<8>(bytes), hn::Set(kI, 255)));
      v[2] = hn::ConvertTo(kF, hn::And(hn::ShiftRight<16>(bytes), hn::Set(kI, 255)));
      v[3] = hn::ConvertTo(kF, hn::And(hn::ShiftRight<24>(bytes), hn::Set(kI, 255)));
    } else {
      pair(at - 1, v[0], v[1]);
      pair(at + 1, v[2], v[3]);
    }
  }

  // Four bytes from `at` voxels past each lane's own.
  HWY_INLINE VI gather(std::ptrdiff_t at, VI bytes) const {
    return hn::GatherOffset(kI, reinterpret_cast<const std::int32_t*>(voxels_ + at), bytes);
  }

  HWY_INLINE void split(VI both, VF& a, VF& b) const {
    if constexpr (std::is_signed_v<T>) {
      a = hn::ConvertTo(kF, hn::ShiftRight<16>(hn::ShiftLeft<16>(both)));
      b = hn::ConvertTo(kF, hn::ShiftRight<16>(both));
    } else {
      a = hn::ConvertTo(kF, hn::And(both, hn::Set(kI, 0xFFFF)));
      b = hn::ConvertTo(kF, hn::And(hn::ShiftRight<16>(both), hn::Set(kI, 0xFFFF)));
    }
  }

  // One voxel a lane, without the vectors' gathers, which reach 2^31 bytes at most.
  HWY_INLINE void each(std::ptrdiff_t at, VF& v) const {
    alignas(64) float values[RayLanes::kCount];
    for (std::size_t n = 0; n < hn::Lanes(kF); ++n) {
      values[n] = static_cast<float>(voxels_[wide_[n] + at]);
    }
    v = hn::Load(kF, values);
  }

  const T* voxels_;
  std::ptrdiff_t row_, slice_;
  VI bytes_ = hn::Zero(kI);
  std::ptrdiff_t wide_[kWide ? RayLanes::kCount : 1];
};

}  // namespace isolux::lanes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

#endif
