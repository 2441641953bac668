// Elementary functions in lanes of floats, the same in every lane and on every instruction set with
// fused operations. Compiled once for each instruction set, so guarded as Highway asks.
#if defined(ISOLUX_BASE_LANE_MATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOLUX_BASE_LANE_MATH_INL_H_
#undef ISOLUX_BASE_LANE_MATH_INL_H_
#else
#define ISOLUX_BASE_LANE_MATH_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isolux::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// 2^y for y in [-126, 126], relative error below 3e-7: the nearest whole number goes into the
// exponent, Taylor's series does the rest.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V lane_exp2(D d, V y) {
  const hn::RebindToSigned<D> di;
  const V whole = hn::Round(y);
  const V x = hn::Mul(hn::Sub(y, whole), hn::Set(d, 0.693147180559945f));
  V series = hn::Set(d, 1.0f / 720);
  for (const float term : {1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f, 1.0f, 1.0f}) {
    series = hn::MulAdd(series, x, hn::Set(d, term));
  }
  const auto exponent = hn::ShiftLeft<23>(hn::ConvertTo(di, whole));
  return hn::BitCast(d, hn::Add(hn::BitCast(di, series), exponent));
}

// log2(1 - u) for u in [0, 1), with all of u's digits where it is small. ln m = 2 artanh((m - 1) /
// (m + 1)), with m in [1/sqrt 2, sqrt 2].
template <class D, class V = hn::Vec<D>>
HWY_INLINE V lane_log2_of_1_minus(D d, V u) {
  const hn::RebindToSigned<D> di;
  const V x = hn::Sub(hn::Set(d, 1.0f), u);
  const auto bits = hn::BitCast(di, x);
  const auto exponent =
      hn::ShiftRight<23>(hn::Sub(bits, hn::Set(di, 0x3F3504F3)));  // of x / (1 / sqrt 2)
  const V m = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  const auto is_near_1 = hn::RebindMask(d, hn::Eq(exponent, hn::Zero(di)));
  const V f = hn::IfThenElse(is_near_1, hn::Neg(u), hn::Sub(m, hn::Set(d, 1.0f)));
  const V z = hn::Div(f, hn::Add(f, hn::Set(d, 2.0f)));
  const V z2 = hn::Mul(z, z);
  V series = hn::Set(d, 1.0f / 9);
  for (const float term : {1.0f / 7, 1.0f / 5, 1.0f / 3, 1.0f}) {
    series = hn::MulAdd(series, z2, hn::Set(d, term));
  }
  const V two_over_ln2 = hn::Set(d, 2.885390081777927f);
  return hn::MulAdd(hn::Mul(z, series), two_over_ln2, hn::ConvertTo(d, exponent));
}

// (1 - u)^n for u in [0, 1] and n > 0; below 2^-126 it is 0.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V lane_pow_of_1_minus(D d, V u, float n) {
  const V y = hn::Mul(hn::Set(d, n), lane_log2_of_1_minus(d, u));
  const V least = hn::Set(d, -126.0f);
  const auto is_0 = hn::Or(hn::Lt(y, least), hn::Ge(u, hn::Set(d, 1.0f)));
  return hn::IfThenZeroElse(is_0, lane_exp2(d, hn::Max(y, least)));
}

}  // namespace isolux::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
