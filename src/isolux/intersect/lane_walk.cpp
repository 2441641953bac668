#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/intersect/lane_walk.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include "isolux/intersect/lane_voxels-inl.h"
#include "isolux/intersect/lane_walk.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::lanes::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

// A machine without SSE4: the oracle does everything.
void walk_here(const Field&, const RayLanes&, std::uint32_t lanes, HitLanes*, Found& found) {
  found.undecided = lanes;
}

#else

constexpr float kRounding = 1e-6f;  // relative, of the t of a border plane

// The double vectors that hold the lanes of one float vector.
struct Doubles {
  VD low, high;
};

HWY_INLINE Doubles load(const double* from) {
  return {hn::Load(kD, from), hn::Load(kD, from + hn::Lanes(kD))};
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
HWY_INLINE VI nearest_int(VF v) {
  const VF magic = hn::Set(kF, 12582912.0f);
  return hn::Sub(hn::BitCast(kI, hn::Add(v, magic)), hn::BitCast(kI, magic));
}

// A ray in floats, seen from an integer point near where its walk begins.
struct Axis {
  VF origin, direction;
  VF cell_origin;      // origin - 1/2, so that rounding to nearest gives the cell
  VF inverse, offset;  // t of a plane = plane * inverse + offset
  MF up;               // runs towards higher indices
  VI base;             // the integer point, a block's corner
};

HWY_INLINE VF plane_t(const Axis& axis, VI plane) {
  return hn::MulAdd(hn::ConvertTo(kF, plane), axis.inverse, axis.offset);
}

HWY_INLINE VF lerp(VF a, VF b, VF w) { return hn::MulAdd(w, hn::Sub(b, a), a); }

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

// The zero in [low, high], by Newton's method with bisection as its guard; `value` is what is left
// there.
HWY_INLINE VF zero_between(const Cubic& p, VF low, VF high, VF& value) {
  const VF zero = hn::Zero(kF), half = hn::Set(kF, 0.5f);
  const VF at_low = p.at(low), at_high = p.at(high);
  VF s = hn::MulAdd(hn::Sub(high, low), hn::Div(at_low, hn::Sub(at_low, at_high)), low);
  value = p.at(s);
  for (int step = 0; step < 5; ++step) {
    const MF before = hn::Gt(value, zero);
    low = hn::IfThenElse(before, s, low);
    high = hn::IfThenElse(before, high, s);
    const VF next = hn::Sub(s, hn::Div(value, p.slope(s)));
    const MF guarded = hn::And(hn::Ge(next, low), hn::Le(next, high));
    s = hn::IfThenElse(guarded, next, hn::Mul(half, hn::Add(low, high)));
    value = p.at(s);
  }
  return s;
}

// The lanes of one vector on their way through the volume.
template <typename T, bool kWide>
class Walk {
 public:
  HWY_INLINE Walk(const Field& field, const RayLanes& rays, std::size_t first)
      : field_(field), rays_(rays), first_(first) {}

  HWY_INLINE void begin(std::uint32_t lanes) {
    active_ = start(lanes);
    met_lanes_ = undecided_ = walking_ = candidates_ = hn::FirstN(kF, 0);
  }

  // Whether any lane still has somewhere to go. Then all of them walk.
  HWY_INLINE bool set_out() {
    walking_ = hn::And(active_, hn::Lt(t_, end_));
    candidates_ = hn::FirstN(kF, 0);
    return is_walking();
  }
  HWY_INLINE bool is_walking() const { return !hn::AllFalse(kF, walking_); }

  // One step of the walking lanes. Those that come to stand in a cell that can hold the surface
  // stop there; where they would go next is in next_t_ and next_cell_.
  HWY_INLINE void step() {
    const VI zero = hn::Zero(kI), one = hn::Set(kI, 1);
    VI blocks = hn::Add(block_, hn::ShiftRight<2>(cell_[0]));
    blocks =
        hn::Add(blocks, hn::Mul(hn::ShiftRight<2>(cell_[1]), hn::Set(kI, field_.block_stride_y)));
    blocks =
        hn::Add(blocks, hn::Mul(hn::ShiftRight<2>(cell_[2]), hn::Set(kI, field_.block_stride_z)));
    blocks = hn::Min(hn::Max(blocks, zero), hn::Set(kI, field_.block_count - 1));
    const VI leap =
        hn::And(hn::GatherOffset(kI, reinterpret_cast<const std::int32_t*>(field_.leaps), blocks),
                hn::Set(kI, 255));
    const MI near = hn::Eq(leap, zero);
    // How far the box reaches that holds nothing else: the cube of empty blocks,
    VI keep = hn::Set(kI, ~3);
    VI upper = hn::ShiftLeft<2>(leap);
    VI lower = hn::Sub(hn::Set(kI, 4), upper);
    MF found = hn::FirstN(kF, 0);
    if (!hn::AllFalse(kI, near)) {
      const VI word = hn::Add(hn::Add(blocks, blocks), hn::And(hn::ShiftRight<1>(cell_[2]), one));
      const VI bits =
          hn::GatherIndex(kI, reinterpret_cast<const std::int32_t*>(field_.cells), word);
      const VI two = hn::Set(kI, 2);
      const VI octant = hn::Add(hn::And(cell_[0], two), hn::ShiftLeft<2>(hn::And(cell_[1], two)));
      const VI in_octant = hn::And(hn::Shr(bits, octant), hn::Set(kI, 0x00330033));
      const VI bit =
          hn::Add(hn::Add(hn::And(cell_[0], one), hn::ShiftLeft<2>(hn::And(cell_[1], one))),
                  hn::ShiftLeft<4>(hn::And(cell_[2], one)));
      const VI here = hn::And(in_octant, hn::Shl(one, bit));
      found = hn::And(walking_, hn::RebindMask(kF, hn::And(near, hn::Ne(here, zero))));
      // an empty 2^3 octant, or the cell.
      const MI empty = hn::Eq(in_octant, zero);
      const VI size = hn::IfThenElse(empty, two, one);
      keep = hn::IfThenElse(near, hn::Neg(size), keep);
      upper = hn::IfThenElse(near, size, upper);
      lower = hn::IfThenZeroElse(near, lower);
    }
    VI plane[3];
    VF t[3];
    for (int a = 0; a < 3; ++a) {
      const MI up = hn::RebindMask(kI, axis_[a].up);
      plane[a] = hn::Add(hn::And(cell_[a], keep), hn::IfThenElse(up, upper, lower));
      t[a] = plane_t(axis_[a], plane[a]);
    }
    const VF leave = hn::Min(t[0], hn::Min(t[1], t[2]));
    const VF next_t = hn::Max(leave, t_);
    const MI stay = hn::RebindMask(kI, found);
    const MI step = hn::Eq(keep, hn::Set(kI, -1));  // the other two axes stay as they are
    const MI go = hn::RebindMask(kI, hn::AndNot(found, walking_));
    for (int a = 0; a < 3; ++a) {
      const MI up = hn::RebindMask(kI, axis_[a].up);
      // Never back, or two axes whose planes meet at one t could undo each other's steps for ever.
      const VI reached = nearest_int(hn::MulAdd(axis_[a].direction, next_t, axis_[a].cell_origin));
      const VI here = hn::IfThenElse(up, hn::Max(reached, cell_[a]), hn::Min(reached, cell_[a]));
      const VI beyond = hn::IfThenElse(up, plane[a], hn::Sub(plane[a], one));
      const MI through = hn::RebindMask(kI, hn::Eq(t[a], leave));
      const VI next = hn::IfThenElse(through, beyond, hn::IfThenElse(step, cell_[a], here));
      next_cell_[a] = hn::IfThenElse(stay, next, next_cell_[a]);
      cell_[a] = hn::IfThenElse(go, next, cell_[a]);
    }
    next_t_ = hn::IfThenElse(found, next_t, next_t_);
    t_ = hn::IfThenElse(hn::RebindMask(kF, go), next_t, t_);
    candidates_ = hn::Or(candidates_, found);
    walking_ = hn::And(hn::AndNot(found, walking_), hn::Lt(t_, end_));
  }

  // Looks for the surface in the cells where walking lanes have stopped.
  HWY_INLINE void look() {
    active_ = candidates_;
    if (hn::AllFalse(kF, active_)) return;
    const MF met = solve(active_, undecided_);
    met_lanes_ = hn::Or(met_lanes_, met);
    active_ = hn::AndNot(hn::Or(met, undecided_), active_);
    // Past the cell that was looked at in vain.
    t_ = hn::IfThenElse(active_, next_t_, t_);
    for (int a = 0; a < 3; ++a) {
      cell_[a] = hn::IfThenElse(hn::RebindMask(kI, active_), next_cell_[a], cell_[a]);
    }
  }

  void go_alone() {
    while (is_walking()) {
      while (is_walking()) step();
      look();
      set_out();
    }
  }

  HWY_INLINE void end(HitLanes* hits, Found& found) {
    if (!hn::AllFalse(kF, hn::Or(met_lanes_, undecided_))) {
      finish(met_lanes_, undecided_, hits, found);
    }
  }

 private:
  // Clips the rays to the volume and settles where each walk begins.
  HWY_INLINE MF start(std::uint32_t lanes) {
    const VF zero = hn::Zero(kF);
    MF active = mask_of(lanes);
    VF from = hn::Load(kF, rays_.begin + first_);
    // A little further than the end: finish() compares with the end itself, in doubles.
    VF to = hn::Mul(hn::Load(kF, rays_.end + first_), hn::Set(kF, 1 + kRounding));
    VF largest = zero;
    for (int a = 0; a < 3; ++a) {
      axis_[a].direction = to_floats(load(rays_.direction[a] + first_));
      largest = hn::Max(largest, hn::Abs(axis_[a].direction));
    }
    const VF parallel = hn::Mul(largest, hn::Set(kF, 1e-13f));
    MF still[3];
    for (int a = 0; a < 3; ++a) {
      const VF d = axis_[a].direction;
      still[a] = hn::Le(hn::Abs(d), parallel);
      const Doubles origin = load(rays_.origin[a] + first_);
      const double last = field_.dims[a] - 1;
      // Signed distances to the two border planes: exact enough to tell a ray within one of them.
      const VD slack = hn::Set(kD, 1e-9), far = hn::Set(kD, last);
      const VF above = to_floats({hn::Add(origin.low, slack), hn::Add(origin.high, slack)});
      const VF below = to_floats(
          {hn::Sub(hn::Add(far, slack), origin.low), hn::Sub(hn::Add(far, slack), origin.high)});
      const MF within = hn::And(hn::Ge(above, zero), hn::Ge(below, zero));
      axis_[a].inverse = hn::Div(hn::Set(kF, 1.0f), d);
      const VF t0 = hn::Neg(hn::Mul(above, axis_[a].inverse));
      const VF t1 = hn::Mul(below, axis_[a].inverse);
      const VF near = hn::Min(t0, t1), far_t = hn::Max(t0, t1);
      const VF rounding = hn::Set(kF, kRounding);
      const VF near_out = hn::NegMulAdd(rounding, hn::Abs(near), near);
      const VF far_out = hn::MulAdd(rounding, hn::Abs(far_t), far_t);
      from = hn::IfThenElse(still[a], from, hn::Max(from, near_out));
      to = hn::IfThenElse(still[a], to, hn::Min(to, far_out));
      active = hn::And(active, hn::Or(within, hn::Not(still[a])));
    }
    active = hn::And(active, hn::Le(from, to));
    from_ = hn::IfThenElseZero(active, from);
    end_ = hn::IfThenElseZero(active, hn::Sub(to, from));
    const Doubles from_d = to_doubles(from_);
    VI block = hn::Set(kI, 0);
    for (int a = 0; a < 3; ++a) settle(a, from_d, still[a], block);
    block_ = block;
    t_ = next_t_ = zero;
    side_ = zero;
    met_.cubic = {zero, zero, zero, zero};
    met_.low = met_.high = met_.t = met_.span = zero;
    for (int a = 0; a < 3; ++a) {
      met_.entry[a] = met_.step[a] = zero;
      met_.cell[a] = next_cell_[a] = hn::Zero(kI);
    }
    return active;
  }

  HWY_INLINE void settle(int a, const Doubles& from, MF still, VI& block) {
    Axis& axis = axis_[a];
    const Doubles o = load(rays_.origin[a] + first_), d = load(rays_.direction[a] + first_);
    const VD low = hn::MulAdd(d.low, from.low, o.low), high = hn::MulAdd(d.high, from.high, o.high);
    const std::int32_t last = field_.dims[a] - 2;
    const VI cell =
        hn::Min(hn::Max(hn::ConvertTo(kI, hn::Floor(to_floats({low, high}))), hn::Set(kI, 0)),
                hn::Set(kI, last));
    axis.base = hn::And(cell, hn::Set(kI, ~3));
    const Doubles base = to_doubles(hn::ConvertTo(kF, axis.base));
    // A start on the outermost plane belongs to the last cell.
    const VF most =
        hn::Sub(hn::ConvertTo(kF, hn::Sub(hn::Set(kI, last + 1), axis.base)), hn::Set(kF, 5e-7f));
    const VF least = hn::ConvertTo(kF, hn::Neg(axis.base));
    const VF origin = to_floats({hn::Sub(low, base.low), hn::Sub(high, base.high)});
    axis.origin = hn::Max(hn::Min(origin, most), least);
    axis.cell_origin = hn::Sub(axis.origin, hn::Set(kF, 0.5f));
    axis.direction = hn::IfThenZeroElse(still, axis.direction);
    axis.inverse = hn::IfThenZeroElse(still, axis.inverse);
    axis.offset =
        hn::IfThenElse(still, hn::Set(kF, 1e30f), hn::Neg(hn::Mul(axis.origin, axis.inverse)));
    axis.up = hn::Gt(axis.direction, hn::Zero(kF));
    cell_[a] = hn::Sub(cell, axis.base);
    const std::int32_t stride = a == 0 ? 1 : a == 1 ? field_.block_stride_y : field_.block_stride_z;
    const VI blocks = hn::Add(hn::ShiftRight<2>(axis.base), hn::Set(kI, 1));
    block = hn::Add(block, hn::Mul(blocks, hn::Set(kI, stride)));
  }

  // Looks for the first root in the cells where the active lanes stand.
  HWY_INLINE MF solve(MF active, MF& undecided) {
    VI at[3];
    VF entry[3], step[3];
    // Where the walk ends it may still be inside the volume, by a rounding: look a little further.
    const VF rest = hn::Mul(hn::Set(kF, 4 * kRounding), hn::Add(from_, end_));
    const MF leaving = hn::Ge(hn::Add(next_t_, rest), end_);
    const VF span = hn::Add(hn::Sub(next_t_, t_), hn::IfThenElseZero(leaving, rest));
    const Doubles t = to_doubles(t_), from = to_doubles(from_);
    const VD t_low = hn::Add(from.low, t.low), t_high = hn::Add(from.high, t.high);
    for (int a = 0; a < 3; ++a) {
      at[a] = hn::Add(axis_[a].base, cell_[a]);
      const Doubles o = load(rays_.origin[a] + first_), d = load(rays_.direction[a] + first_);
      const Doubles corner = to_doubles(hn::ConvertTo(kF, at[a]));
      entry[a] = to_floats({hn::MulAdd(d.low, t_low, hn::Sub(o.low, corner.low)),
                            hn::MulAdd(d.high, t_high, hn::Sub(o.high, corner.high))});
      step[a] = hn::Mul(axis_[a].direction, span);
      // A walk that rounding has carried far out may take another block's bits for its own.
      const MI inside =
          hn::And(hn::Gt(at[a], hn::Set(kI, -1)), hn::Lt(at[a], hn::Set(kI, field_.dims[a] - 1)));
      active = hn::And(active, hn::RebindMask(kF, inside));
    }
    const Voxels<T, kWide> voxels(field_, at, hn::RebindMask(kI, active), 0);
    VF c[8];
    voxels.corners(c);
    for (VF& corner : c) corner = hn::Sub(corner, hn::Set(kF, field_.iso));
    if (field_.iso_rest != 0) {
      for (VF& corner : c) corner = hn::Sub(corner, hn::Set(kF, field_.iso_rest));
    }
    Cubic p = along(c, entry, step);
    // Turned so that the side where the ray comes from is positive.
    const VF zero = hn::Zero(kF), doubt = hn::Set(kF, field_.doubt);
    const MF fresh = hn::And(active, hn::Eq(side_, zero));
    undecided = hn::Or(undecided, hn::And(fresh, hn::Le(hn::Abs(p.c0), doubt)));
    side_ = hn::IfThenElse(fresh, hn::CopySign(hn::Set(kF, 1.0f), p.c0), side_);
    const VF sign = hn::And(side_, hn::BitCast(kF, hn::Set(kI, INT32_MIN)));
    for (VF* const term : {&p.c0, &p.c1, &p.c2, &p.c3}) *term = hn::Xor(*term, sign);
    undecided = hn::Or(undecided, hn::And(active, hn::Le(p.c0, zero)));

    // By its Bernstein coefficients, without a root where all are positive. With one change of
    // sign among them it has one root.
    const VF third = hn::Set(kF, 1.0f / 3.0f);
    const VF b1 = hn::MulAdd(third, p.c1, p.c0);
    const VF b2 = hn::MulAdd(third, hn::MulAdd(hn::Set(kF, 2.0f), p.c1, p.c2), p.c0);
    const VF b3 = hn::Add(hn::Add(p.c0, p.c1), hn::Add(p.c2, p.c3));
    const MF clear = hn::Gt(hn::Min(hn::Min(p.c0, b1), hn::Min(b2, b3)), doubt);
    MF met = hn::AndNot(hn::Or(clear, undecided), active);
    if (hn::AllFalse(kF, met)) return met;
    const MF waves = hn::And(hn::Lt(b1, doubt), hn::Gt(b2, hn::Neg(doubt)));
    const MF once = hn::AndNot(waves, hn::Lt(b3, hn::Neg(doubt)));
    VF low = zero, high = hn::Set(kF, 1.0f);
    const MF look = hn::AndNot(once, met);
    if (!hn::AllFalse(kF, look)) {
      const Bracket change = first_change(p, doubt);
      undecided = hn::Or(undecided, hn::And(look, change.undecided));
      met = hn::AndNot(undecided, hn::And(met, hn::Or(once, change.found)));
      low = hn::IfThenElse(look, change.low, low);
      high = hn::IfThenElse(look, change.high, high);
    }
    keep(met, p.c0, met_.cubic.c0);
    keep(met, p.c1, met_.cubic.c1);
    keep(met, p.c2, met_.cubic.c2);
    keep(met, p.c3, met_.cubic.c3);
    keep(met, low, met_.low);
    keep(met, high, met_.high);
    keep(met, t_, met_.t);
    keep(met, span, met_.span);
    for (int a = 0; a < 3; ++a) {
      keep(met, entry[a], met_.entry[a]);
      keep(met, step[a], met_.step[a]);
      met_.cell[a] = hn::IfThenElse(hn::RebindMask(kI, met), at[a], met_.cell[a]);
    }
    return met;
  }

  static HWY_INLINE void keep(MF lanes, VF value, VF& place) {
    place = hn::IfThenElse(lanes, value, place);
  }

  // Where exactly the lanes that met the surface did so, and whether before the ray's end.
  HWY_INLINE void finish(MF met, MF undecided, HitLanes* hits, Found& found) {
    const VF zero = hn::Zero(kF), one = hn::Set(kF, 1.0f);
    VF value;
    const VF s = zero_between(met_.cubic, met_.low, met_.high, value);
    MF sound = hn::Le(hn::Abs(value), hn::Set(kF, 0.5f * field_.doubt));
    // Where the walk began it may still have been outside the volume, by a rounding.
    const VF along = hn::Mul(s, met_.span);
    sound =
        hn::And(sound, hn::Gt(hn::Add(met_.t, along), hn::Mul(hn::Set(kF, 4 * kRounding), from_)));
    // Between two cells the walk's floats may keep to the wrong one for a hair's breadth.
    VF local[3];
    for (int a = 0; a < 3; ++a) {
      const VF exact = hn::MulAdd(s, met_.step[a], met_.entry[a]);
      local[a] = hn::Min(hn::Max(exact, zero), one);
      sound = hn::And(sound, hn::Le(hn::Abs(hn::Sub(exact, local[a])), hn::Set(kF, 5e-7f)));
    }
    undecided = hn::Or(undecided, hn::AndNot(sound, met));
    found.undecided |= bits_of(undecided) << first_;

    const Doubles from = to_doubles(from_), in = to_doubles(met_.t), rest = to_doubles(along);
    const Doubles t = {hn::Add(hn::Add(from.low, in.low), rest.low),
                       hn::Add(hn::Add(from.high, in.high), rest.high)};
    const Doubles end = to_doubles(hn::Load(kF, rays_.end + first_));
    const MF hit = hn::And(hn::And(met, sound), is_less(t, end));
    found.hit |= bits_of(hit) << first_;
    if (!hits) return;
    hn::Store(t.low, kD, hits->t + first_);
    hn::Store(t.high, kD, hits->t + first_ + hn::Lanes(kD));
    for (int a = 0; a < 3; ++a) {
      hn::Store(met_.cell[a], kI, found.cell[a] + first_);
      hn::Store(local[a], kF, found.local[a] + first_);
    }
    MF away = hn::FirstN(kF, 0);
    const MF without = normals(hit, local, away, *hits);
    found.away |= bits_of(away) << first_;
    found.without_normal |= bits_of(without) << first_;
  }

  // The trilinear blend of central differences, carried into world space. Returns the lanes where
  // it must be looked at more closely: at the volume's border, or where it all but vanishes.
  HWY_INLINE MF normals(MF hit, const VF (&local)[3], MF& away, HitLanes& hits) {
    MI inner = hn::RebindMask(kI, hit);
    for (int a = 0; a < 3; ++a) {
      inner = hn::And(inner, hn::And(hn::Gt(met_.cell[a], hn::Zero(kI)),
                                     hn::Lt(met_.cell[a], hn::Set(kI, field_.dims[a] - 2))));
    }
    const MF whole = hn::RebindMask(kF, inner);
    if (hn::AllFalse(kF, whole)) return hit;
    const Voxels<T, kWide> voxels(field_, met_.cell, inner, 1);
    VF gradient[3], spread = hn::Zero(kF);
    voxels.gradient(local, gradient, spread);
    VF n[3];
    VF square = hn::Zero(kF);
    for (int row = 0; row < 3; ++row) {
      const float(&m)[3] = field_.world_from_covector[row];
      VF sum = hn::Mul(hn::Set(kF, m[0]), gradient[0]);
      sum = hn::MulAdd(hn::Set(kF, m[1]), gradient[1], sum);
      n[row] = hn::Neg(hn::MulAdd(hn::Set(kF, m[2]), gradient[2], sum));
      square = hn::MulAdd(n[row], n[row], square);
    }
    const VF length = hn::Sqrt(square);
    for (int row = 0; row < 3; ++row) {
      hn::Store(hn::Div(n[row], length), kF, hits.normal[row] + first_);
    }
    // The normal is -M^-T g, so its product with the world direction M d is -g . d.
    VF product = hn::Mul(gradient[0], axis_[0].direction);
    for (int a = 1; a < 3; ++a) product = hn::MulAdd(gradient[a], axis_[a].direction, product);
    away = hn::And(whole, hn::Lt(product, hn::Zero(kF)));
    VF longest = hn::Abs(gradient[0]);
    for (int a = 1; a < 3; ++a) longest = hn::Max(longest, hn::Abs(gradient[a]));
    const MF sound =
        hn::And(hn::Gt(longest, hn::Mul(hn::Set(kF, 1e-4f), spread)),
                hn::And(hn::Gt(square, hn::Set(kF, 1e-30f)), hn::Lt(square, hn::Set(kF, 1e30f))));
    return hn::AndNot(hn::And(whole, sound), hit);
  }

  static HWY_INLINE MF mask_of(std::uint32_t lanes) {
    std::uint8_t bits[8] = {static_cast<std::uint8_t>(lanes),
                            static_cast<std::uint8_t>(lanes >> 8)};
    return hn::LoadMaskBits(kF, bits);
  }
  static HWY_INLINE std::uint32_t bits_of(MF mask) {
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(kF, mask, bits);
    return static_cast<std::uint32_t>(bits[0] | bits[1] << 8);
  }

  const Field& field_;
  const RayLanes& rays_;
  std::size_t first_;
  MF active_;      // have not met the surface yet
  MF walking_;     // of these, the ones on their way to the next cell
  MF candidates_;  // and the ones that stand in it
  MF met_lanes_, undecided_;
  Axis axis_[3];
  VF from_, end_;  // the walk's t is counted from `from_`
  VF t_, next_t_;
  VI block_;  // index of the block at the rays' bases
  VI cell_[3], next_cell_[3];
  VF side_;  // the field's sign where the ray comes from; 0: not yet known

  // What is known of the lanes that met the surface: the field in that cell, along the ray.
  struct {
    Cubic cubic;
    VF low, high;  // the root lies between
    VF t, span;    // of the ray's piece in the cell
    VF entry[3], step[3];
    VI cell[3];
  } met_;
};

template <typename T, bool kWide>
void walk_all(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes* hits,
              Found& found) {
  const std::size_t step = hn::Lanes(kF);
  const auto mine = [&](std::size_t first) { return lanes >> first & ((1u << step) - 1); };
  // Two vectors at a time, in turn: while one waits for memory, the other computes.
  for (std::size_t first = 0; first < RayLanes::kCount; first += 2 * step) {
    if ((mine(first) | mine(first + step)) == 0) continue;
    Walk<T, kWide> a(field, rays, first), b(field, rays, first + step);
    a.begin(mine(first));
    b.begin(mine(first + step));
    bool a_goes = a.set_out(), b_goes = b.set_out();
    while (a_goes && b_goes) {
      // One that stands does not wait for the other: it looks and goes on.
      while (a.is_walking() && b.is_walking()) {
        a.step();
        b.step();
      }
      if (!a.is_walking()) {
        a.look();
        a_goes = a.set_out();
      }
      if (!b.is_walking()) {
        b.look();
        b_goes = b.set_out();
      }
    }
    a.go_alone();
    b.go_alone();
    a.end(hits, found);
    b.end(hits, found);
  }
}

void walk_here(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes* hits,
               Found& found) {
  const auto with = [&]<typename T>(T) {
    field.is_wide ? walk_all<T, true>(field, rays, lanes, hits, found)
                  : walk_all<T, false>(field, rays, lanes, hits, found);
  };
  switch (field.type) {
    case VoxelType::kU8:
      return with(std::uint8_t{});
    case VoxelType::kI16:
      return with(std::int16_t{});
    case VoxelType::kU16:
      return with(std::uint16_t{});
    case VoxelType::kF32:
      return with(float{});
  }
}

#endif

}  // namespace
}  // namespace isolux::lanes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux::lanes {

HWY_EXPORT(walk_here);

void walk(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes* hits,
          Found& found) {
  HWY_DYNAMIC_DISPATCH(walk_here)(field, rays, lanes, hits, found);
}

}  // namespace isolux::lanes
#endif
