// The field along a ray inside a cell, and its roots, in lanes.
// Compiled once for each instruction set, so guarded as Highway asks.
#if defined(ISOLUX_INTERSECT_LANE_CUBIC_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOLUX_INTERSECT_LANE_CUBIC_INL_H_
#undef ISOLUX_INTERSECT_LANE_CUBIC_INL_H_
#else
#define ISOLUX_INTERSECT_LANE_CUBIC_INL_H_
#endif

#include <hwy/highway.h>

#include "isolux/intersect/lane_vectors-inl.h"

#if HWY_TARGET != HWY_SCALAR
HWY_BEFORE_NAMESPACE();
namespace isolux::lanes::HWY_NAMESPACE {
// Value and first two powers of a polynomial in s.
struct Cubic {
  VF c0, c1, c2, c3;

  HWY_INLINE VF at(VF s) const {
    return hn::MulAdd(s, hn::MulAdd(s, hn::MulAdd(s, c3, c2), c1), c0);
  }
  HWY_INLINE VF slope(VF s) const {
    const VF two = hn::Set(kF, 2.0f), three = hn::Set(kF, 3.0f);
    return hn::MulAdd(s, hn::MulAdd(s, hn::Mul(three, c3), hn::Mul(two, c2)), c1);
  }
};

// The trilinear interpolant of corners c along entry + s * step: four edges along x, joined along
// y, then along z, as polynomials in s.
HWY_INLINE Cubic along(const VF (&c)[8], const VF (&entry)[3], const VF (&step)[3]) {
  VF e0[4], e1[4];  // edges: e0 + e1 s
  for (int edge = 0; edge < 4; ++edge) {
    const VF rise = hn::Sub(c[2 * edge + 1], c[2 * edge]);
    e0[edge] = hn::MulAdd(entry[0], rise, c[2 * edge]);
    e1[edge] = hn::Mul(step[0], rise);
  }
  VF f0[2], f1[2], f2[2];  // faces: f0 + f1 s + f2 s^2
  for (int face = 0; face < 2; ++face) {
    const VF d0 = hn::Sub(e0[2 * face + 1], e0[2 * face]);
    const VF d1 = hn::Sub(e1[2 * face + 1], e1[2 * face]);
    f0[face] = hn::MulAdd(entry[1], d0, e0[2 * face]);
    f1[face] = hn::MulAdd(step[1], d0, hn::MulAdd(entry[1], d1, e1[2 * face]));
    f2[face] = hn::Mul(step[1], d1);
  }
  const VF d0 = hn::Sub(f0[1], f0[0]);
  const VF d1 = hn::Sub(f1[1], f1[0]);
  const VF d2 = hn::Sub(f2[1], f2[0]);
  return {hn::MulAdd(entry[2], d0, f0[0]), hn::MulAdd(step[2], d0, hn::MulAdd(entry[2], d1, f1[0])),
          hn::MulAdd(step[2], d1, hn::MulAdd(entry[2], d2, f2[0])), hn::Mul(step[2], d2)};
}

// Where in (0, 1) the slope is zero, in order; 1 where it is not.
HWY_INLINE void turning_points(const Cubic& p, VF& first, VF& second) {
  const VF zero = hn::Zero(kF), one = hn::Set(kF, 1.0f);
  const VF three_c3 = hn::Mul(hn::Set(kF, 3.0f), p.c3);
  const VF discriminant = hn::MulSub(p.c2, p.c2, hn::Mul(three_c3, p.c1));
  const MF real = hn::Gt(discriminant, zero);
  const VF root = hn::Sqrt(hn::Max(discriminant, zero));
  const VF q = hn::Neg(hn::Add(p.c2, hn::CopySign(root, p.c2)));
  const auto inside = [&](VF s) HWY_ATTR {
    const MF in = hn::And(hn::And(hn::Gt(s, zero), hn::Lt(s, one)), real);
    return hn::IfThenElse(in, s, one);
  };
  const VF a = inside(hn::Div(q, three_c3));
  const VF b = inside(hn::Div(p.c1, q));
  first = hn::Min(a, b);
  second = hn::Max(a, b);
}

// A piece of [0, 1] in which a cubic that is positive at its lower end first reaches zero.
struct Bracket {
  MF found;
  MF undecided;  // floats cannot tell
  VF low, high;
};

// The piece for a cubic that is positive at 0: between the turning points, it is monotone.
HWY_INLINE Bracket first_change(const Cubic& p, VF doubt) {
  const VF zero = hn::Zero(kF), one = hn::Set(kF, 1.0f);
  VF turn1, turn2;
  turning_points(p, turn1, turn2);
  const VF at1 = p.at(turn1), at2 = p.at(turn2);
  const MF in_first = hn::Le(at1, zero);
  const MF in_second = hn::Le(at2, zero);
  const MF in_third = hn::Le(p.at(one), zero);
  const MF doubt1 = hn::And(hn::Le(hn::Abs(at1), doubt), hn::Lt(turn1, one));
  const MF doubt2 = hn::AndNot(in_first, hn::And(hn::Le(hn::Abs(at2), doubt), hn::Lt(turn2, one)));
  return {hn::Or(in_first, hn::Or(in_second, in_third)), hn::Or(doubt1, doubt2),
          hn::IfThenElse(in_first, zero, hn::IfThenElse(in_second, turn1, turn2)),
          hn::IfThenElse(in_first, turn1, hn::IfThenElse(in_second, turn2, one))};
}

// The zero in [low, high], by Newton's method with bisection as its guard, until no more than
// `enough` is left; `value` is what is.
HWY_INLINE VF zero_between(const Cubic& p, VF low, VF high, VF enough, VF& value) {
  const VF zero = hn::Zero(kF), half = hn::Set(kF, 0.5f);
  const VF at_low = p.at(low), at_high = p.at(high);
  VF s = hn::MulAdd(hn::Sub(high, low), hn::Div(at_low, hn::Sub(at_low, at_high)), low);
  value = p.at(s);
  for (int step = 0; step < 5; ++step) {
    const MF open = hn::Gt(hn::Abs(value), enough);
    if (hn::AllFalse(kF, open)) break;
    const MF before = hn::Gt(value, zero);
    low = hn::IfThenElse(before, s, low);
    high = hn::IfThenElse(before, high, s);
    const VF next = hn::Sub(s, hn::Div(value, p.slope(s)));
    const MF guarded = hn::And(hn::Ge(next, low), hn::Le(next, high));
    const VF better = hn::IfThenElse(guarded, next, hn::Mul(half, hn::Add(low, high)));
    s = hn::IfThenElse(open, better, s);
    value = p.at(s);
  }
  return s;
}

}  // namespace isolux::lanes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

#endif
