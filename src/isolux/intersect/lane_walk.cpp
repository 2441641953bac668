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
void walk_here(const Field&, const RayLanes&, std::uint32_t lanes, HitLanes&, Found& found) {
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

// A ray in floats, seen from an integer point near where its walk begins.
struct Axis {
  VF origin, direction;
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

struct Roots {
  MF hit;        // s is where the sign changes first
  MF undecided;  // floats cannot tell
  VF s;
};

// The first zero in (0, 1] of a cubic that is positive at 0.
HWY_INLINE Roots first_zero(const Cubic& p, VF doubt) {
  const VF zero = hn::Zero(kF), one = hn::Set(kF, 1.0f);
  VF turn1, turn2;
  turning_points(p, turn1, turn2);
  const VF at1 = p.at(turn1), at2 = p.at(turn2), at_end = p.at(one);
  const MF in_first = hn::Le(at1, zero);
  const MF in_second = hn::Le(at2, zero);
  const MF in_third = hn::Le(at_end, zero);
  Roots roots;
  roots.hit = hn::Or(in_first, hn::Or(in_second, in_third));
  const MF doubt1 = hn::And(hn::Le(hn::Abs(at1), doubt), hn::Lt(turn1, one));
  const MF doubt2 = hn::AndNot(in_first, hn::And(hn::Le(hn::Abs(at2), doubt), hn::Lt(turn2, one)));
  roots.undecided = hn::Or(doubt1, doubt2);

  VF low = hn::IfThenElse(in_first, zero, hn::IfThenElse(in_second, turn1, turn2));
  VF high = hn::IfThenElse(in_first, turn1, hn::IfThenElse(in_second, turn2, one));
  const VF at_low = hn::IfThenElse(in_first, p.c0, hn::IfThenElse(in_second, at1, at2));
  const VF at_high = hn::IfThenElse(in_first, at1, hn::IfThenElse(in_second, at2, at_end));
  VF s = hn::MulAdd(hn::Sub(high, low), hn::Div(at_low, hn::Sub(at_low, at_high)), low);
  const VF half = hn::Set(kF, 0.5f);
  VF value = p.at(s);
  for (int step = 0; step < 4; ++step) {
    const MF before = hn::Gt(value, zero);
    low = hn::IfThenElse(before, s, low);
    high = hn::IfThenElse(before, high, s);
    const VF next = hn::Sub(s, hn::Div(value, p.slope(s)));
    const MF guarded = hn::And(hn::Ge(next, low), hn::Le(next, high));
    s = hn::IfThenElse(guarded, next, hn::Mul(half, hn::Add(low, high)));
    value = p.at(s);
  }
  const MF rough = hn::Not(hn::Le(hn::Abs(value), hn::Mul(hn::Set(kF, 0.5f), doubt)));
  roots.undecided = hn::Or(roots.undecided, hn::And(roots.hit, rough));
  roots.hit = hn::AndNot(roots.undecided, roots.hit);
  roots.s = s;
  return roots;
}

// The lanes of one vector on their way through the volume.
template <typename T, bool kWide>
class Walk {
 public:
  HWY_INLINE Walk(const Field& field, const RayLanes& rays, std::size_t first)
      : field_(field), rays_(rays), first_(first) {}

  HWY_INLINE void run(std::uint32_t lanes, HitLanes& hits, Found& found) {
    MF active = begin(lanes);
    MF hit = hn::FirstN(kF, 0), undecided = hn::FirstN(kF, 0);
    while (true) {
      active = next_candidates(active);
      if (hn::AllFalse(kF, active)) break;
      const MF met = solve(active, undecided);
      hit = hn::Or(hit, met);
      active = hn::AndNot(hn::Or(met, undecided), active);
      // Past the cell that was looked at in vain.
      t_ = hn::IfThenElse(active, next_t_, t_);
      for (int a = 0; a < 3; ++a) {
        cell_[a] = hn::IfThenElse(hn::RebindMask(kI, active), next_cell_[a], cell_[a]);
      }
    }
    store(hit, undecided, hits, found);
  }

 private:
  // Clips the rays to the volume and settles where each walk begins.
  HWY_INLINE MF begin(std::uint32_t lanes) {
    const VF zero = hn::Zero(kF);
    MF active = mask_of(lanes);
    VF from = hn::Load(kF, rays_.begin + first_);
    VF to = hn::Load(kF, rays_.end + first_);
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
    t_ = zero;
    side_ = zero;
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

  // Walks until every lane stands in a cell that can hold the surface, or is out. Returns the
  // former; where they go next is in next_t_ and next_cell_.
  HWY_INLINE MF next_candidates(MF walking) {
    MF candidates = hn::FirstN(kF, 0);
    walking = hn::And(walking, hn::Lt(t_, end_));
    const VI zero = hn::Zero(kI), one = hn::Set(kI, 1);
    while (!hn::AllFalse(kF, walking)) {
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
      MF found = hn::FirstN(kF, 0);
      if (!hn::AllFalse(kI, near)) {
        const VI word = hn::Add(hn::Add(blocks, blocks), hn::And(hn::ShiftRight<1>(cell_[2]), one));
        const VI bits =
            hn::GatherIndex(kI, reinterpret_cast<const std::int32_t*>(field_.cells), word);
        const VI three = hn::Set(kI, 3);
        const VI bit =
            hn::Add(hn::Add(hn::And(cell_[0], three), hn::ShiftLeft<2>(hn::And(cell_[1], three))),
                    hn::ShiftLeft<4>(hn::And(cell_[2], one)));
        const VI is_set = hn::And(bits, hn::Shl(one, bit));
        found = hn::And(walking, hn::RebindMask(kF, hn::And(near, hn::Ne(is_set, zero))));
      }
      // To the far side of the cell, or of the cube of empty blocks.
      const VI keep = hn::IfThenElse(near, hn::Set(kI, -1), hn::Set(kI, ~3));
      const VI four = hn::Set(kI, 4);
      const VI upper = hn::IfThenElse(near, one, hn::ShiftLeft<2>(leap));
      const VI lower = hn::IfThenElse(near, zero, hn::Sub(four, hn::ShiftLeft<2>(leap)));
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
      const MI go = hn::RebindMask(kI, hn::AndNot(found, walking));
      for (int a = 0; a < 3; ++a) {
        const VI here =
            hn::ConvertTo(kI, hn::Floor(hn::MulAdd(axis_[a].direction, next_t, axis_[a].origin)));
        const MI up = hn::RebindMask(kI, axis_[a].up);
        const VI beyond = hn::IfThenElse(up, plane[a], hn::Sub(plane[a], one));
        const MI through = hn::RebindMask(kI, hn::Eq(t[a], leave));
        const VI next = hn::IfThenElse(through, beyond, hn::IfThenElse(near, cell_[a], here));
        next_cell_[a] = hn::IfThenElse(stay, next, next_cell_[a]);
        cell_[a] = hn::IfThenElse(go, next, cell_[a]);
      }
      next_t_ = hn::IfThenElse(found, next_t, next_t_);
      t_ = hn::IfThenElse(hn::RebindMask(kF, go), next_t, t_);
      candidates = hn::Or(candidates, found);
      walking = hn::And(hn::AndNot(found, walking), hn::Lt(t_, end_));
    }
    return candidates;
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

    const VF third = hn::Set(kF, 1.0f / 3.0f);
    const VF b1 = hn::MulAdd(third, p.c1, p.c0);
    const VF b2 = hn::MulAdd(third, hn::MulAdd(hn::Set(kF, 2.0f), p.c1, p.c2), p.c0);
    const VF b3 = hn::Add(hn::Add(p.c0, p.c1), hn::Add(p.c2, p.c3));
    const MF clear = hn::Gt(hn::Min(hn::Min(p.c0, b1), hn::Min(b2, b3)), doubt);
    const MF open = hn::AndNot(hn::Or(clear, undecided), active);
    if (hn::AllFalse(kF, open)) return open;
    const Roots roots = first_zero(p, doubt);
    // Where the walk begins it may still be outside the volume, by a rounding.
    const MF at_border =
        hn::Le(hn::MulAdd(roots.s, span, t_), hn::Mul(hn::Set(kF, 4 * kRounding), from_));
    undecided =
        hn::Or(undecided, hn::And(open, hn::Or(roots.undecided, hn::And(roots.hit, at_border))));
    // Between two cells the walk's floats may keep to the wrong one for a hair's breadth.
    VF local[3];
    for (int a = 0; a < 3; ++a) {
      const VF exact = hn::MulAdd(roots.s, step[a], entry[a]);
      local[a] = hn::Min(hn::Max(exact, zero), hn::Set(kF, 1.0f));
      const MF outside = hn::Gt(hn::Abs(hn::Sub(exact, local[a])), hn::Set(kF, 5e-7f));
      undecided = hn::Or(undecided, hn::And(open, hn::And(roots.hit, outside)));
    }
    const MF hit = hn::AndNot(undecided, hn::And(open, roots.hit));
    hit_in_ = hn::IfThenElse(hit, t_, hit_in_);
    hit_span_ = hn::IfThenElse(hit, hn::Mul(roots.s, span), hit_span_);
    for (int a = 0; a < 3; ++a) {
      hit_cell_[a] = hn::IfThenElse(hn::RebindMask(kI, hit), at[a], hit_cell_[a]);
      hit_local_[a] = hn::IfThenElse(hit, local[a], hit_local_[a]);
    }
    return hit;
  }

  HWY_INLINE void store(MF hit, MF undecided, HitLanes& hits, Found& found) {
    const Doubles from = to_doubles(from_), in = to_doubles(hit_in_), span = to_doubles(hit_span_);
    hn::Store(hn::Add(hn::Add(from.low, in.low), span.low), kD, hits.t + first_);
    hn::Store(hn::Add(hn::Add(from.high, in.high), span.high), kD, hits.t + first_ + hn::Lanes(kD));
    for (int a = 0; a < 3; ++a) {
      hn::Store(hit_cell_[a], kI, found.cell[a] + first_);
      hn::Store(hit_local_[a], kF, found.local[a] + first_);
    }
    MF without = hn::FirstN(kF, 0);
    MF away = hn::FirstN(kF, 0);
    if (!hn::AllFalse(kF, hit)) without = normals(hit, away, hits);
    found.away |= bits_of(away) << first_;
    found.hit |= bits_of(hit) << first_;
    found.undecided |= bits_of(undecided) << first_;
    found.without_normal |= bits_of(without) << first_;
  }

  // The trilinear blend of central differences, carried into world space. Returns the lanes where
  // it must be looked at more closely: at the volume's border, or where it all but vanishes.
  HWY_INLINE MF normals(MF hit, MF& away, HitLanes& hits) {
    MI inner = hn::RebindMask(kI, hit);
    for (int a = 0; a < 3; ++a) {
      inner = hn::And(inner, hn::And(hn::Gt(hit_cell_[a], hn::Zero(kI)),
                                     hn::Lt(hit_cell_[a], hn::Set(kI, field_.dims[a] - 2))));
    }
    const MF whole = hn::RebindMask(kF, inner);
    if (hn::AllFalse(kF, whole)) return hit;
    const Voxels<T, kWide> voxels(field_, hit_cell_, inner, 1);
    VF gradient[3], spread = hn::Zero(kF);
    voxels.gradient(hit_local_, gradient, spread);
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
  Axis axis_[3];
  VF from_, end_;  // the walk's t is counted from `from_`
  VF t_, next_t_ = hn::Zero(kF);
  VI block_;  // index of the block at the rays' bases
  VI cell_[3], next_cell_[3] = {hn::Zero(kI), hn::Zero(kI), hn::Zero(kI)};
  VF side_;  // the field's sign where the ray comes from; 0: not yet known
  VF hit_in_ = hn::Zero(kF), hit_span_ = hn::Zero(kF);  // t at the cell's entry, and from there
  VI hit_cell_[3] = {hn::Zero(kI), hn::Zero(kI), hn::Zero(kI)};
  VF hit_local_[3] = {hn::Zero(kF), hn::Zero(kF), hn::Zero(kF)};
};

template <typename T, bool kWide>
void walk_all(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes& hits,
              Found& found) {
  const std::size_t step = hn::Lanes(kF);
  for (std::size_t first = 0; first < RayLanes::kCount; first += step) {
    const std::uint32_t mine = lanes >> first & ((1u << step) - 1);
    if (mine != 0) Walk<T, kWide>(field, rays, first).run(mine, hits, found);
  }
}

void walk_here(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes& hits,
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

void walk(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes& hits,
          Found& found) {
  HWY_DYNAMIC_DISPATCH(walk_here)(field, rays, lanes, hits, found);
}

}  // namespace isolux::lanes
#endif
