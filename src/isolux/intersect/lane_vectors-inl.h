// The vectors of the walk: floats, whole numbers, and doubles in pairs.
// Compiled once for each instruction set, so guarded as Highway asks.
#if defined(ISOLUX_INTERSECT_LANE_VECTORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOLUX_INTERSECT_LANE_VECTORS_INL_H_
#undef ISOLUX_INTERSECT_LANE_VECTORS_INL_H_
#else
#define ISOLUX_INTERSECT_LANE_VECTORS_INL_H_
#endif

#include <hwy/highway.h>

#if HWY_TARGET != HWY_SCALAR
HWY_BEFORE_NAMESPACE();
namespace isolux::lanes::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<float, 16> kF;
constexpr hn::RebindToSigned<decltype(kF)> kI;
constexpr hn::Half<decltype(kF)> kHalfF;
constexpr hn::Rebind<double, decltype(kHalfF)> kD;
using VF = hn::Vec<decltype(kF)>;
using VI = hn::Vec<decltype(kI)>;
using VD = hn::Vec<decltype(kD)>;
using MF = hn::Mask<decltype(kF)>;
using MI = hn::Mask<decltype(kI)>;

// The double vectors that hold the lanes of one float vector.
struct Doubles {
  VD low, high;
};

HWY_INLINE Doubles load(const double* from) {
  return {hn::Load(kD, from), hn::Load(kD, from + hn::Lanes(kD))};
}
HWY_INLINE void store(const Doubles& v, double* to) {
  hn::Store(v.low, kD, to);
  hn::Store(v.high, kD, to + hn::Lanes(kD));
}
HWY_INLINE Doubles to_doubles(VF v) {
  return {hn::PromoteTo(kD, hn::LowerHalf(kHalfF, v)), hn::PromoteTo(kD, hn::UpperHalf(kHalfF, v))};
}
HWY_INLINE VF to_floats(const Doubles& v) {
  return hn::Combine(kF, hn::DemoteTo(kHalfF, v.high), hn::DemoteTo(kHalfF, v.low));
}

// a < b, lane by lane: the difference of two doubles rounds to a float of the same sign, or to 0.
HWY_INLINE MF is_less(const Doubles& a, const Doubles& b) {
  return hn::Lt(to_floats({hn::Sub(a.low, b.low), hn::Sub(a.high, b.high)}), hn::Zero(kF));
}

// Rounds to the nearest whole number, for |v| < 2^22: added to 1.5 * 2^23, a float has no bits left
// for a fraction. (Conversions take more than twice as long.)
template <class V, class DF = hn::DFromV<V>, class DI = hn::RebindToSigned<DF>>
HWY_INLINE hn::Vec<DI> nearest_int(V v) {
  const V magic = hn::Set(DF(), 12582912.0f);
  return hn::Sub(hn::BitCast(DI(), hn::Add(v, magic)), hn::BitCast(DI(), magic));
}

HWY_INLINE MF mask_of(std::uint32_t lanes) {
  std::uint8_t bits[8] = {static_cast<std::uint8_t>(lanes), static_cast<std::uint8_t>(lanes >> 8)};
  return hn::LoadMaskBits(kF, bits);
}
HWY_INLINE std::uint32_t bits_of(MF mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(kF, mask, bits);
  return static_cast<std::uint32_t>(bits[0] | bits[1] << 8);
}

}  // namespace isolux::lanes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

#endif
