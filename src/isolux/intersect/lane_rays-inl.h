// Rays in one vector: clipped to the volume, looked at cell by cell, and told where they hit.
// Compiled once for each instruction set, so guarded as Highway asks.
#if defined(ISOLUX_INTERSECT_LANE_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOLUX_INTERSECT_LANE_RAYS_INL_H_
#undef ISOLUX_INTERSECT_LANE_RAYS_INL_H_
#else
#define ISOLUX_INTERSECT_LANE_RAYS_INL_H_
#endif

#include <hwy/highway.h>

#include "isolux/intersect/lane_cubic-inl.h"
#include "isolux/intersect/lane_voxels-inl.h"
#include "isolux/intersect/lane_walk.h"

#if HWY_TARGET != HWY_SCALAR
HWY_BEFORE_NAMESPACE();
namespace isolux::lanes::HWY_NAMESPACE {

constexpr float kRounding = 1e-6f;  // relative, of the t of a border plane

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

// A piece of the rays of a vector, in the coordinates of one cell for each lane.
struct Piece {
  VI cell[3];
  VF t, span;  // t is counted from where the ray begins
  VF entry[3], step[3];
};

// Rays that have met the surface, a vector of them: the field along each in its cell.
struct Meeting {
  Cubic cubic;
  VF low, high;  // the root lies between
  Piece piece;
  VF from, direction[3];  // of the ray: where t is 0, and its direction
};

// What that comes to.
struct Outcome {
  MF sound;  // else floats cannot tell
  MF hit;    // before the ray's end
  Doubles t;
  VF local[3];
  VF normal[3];
  MF turned, without_normal;
};

// The rays of one vector: where they run.
template <typename T, bool kWide>
class LaneRays {
 protected:
  // Clips the rays from the `first` on to the volume and settles where each walk begins. Returns
  // those of `lanes` that pass through the volume.
  HWY_INLINE MF start(const Field& field, const RayLanes& rays, std::size_t first,
                      std::uint32_t lanes) {
    field_ = &field;
    rays_ = &rays;
    first_ = first;
    const VF zero = hn::Zero(kF);
    MF active = mask_of(lanes);
    VF from = hn::Load(kF, rays_->begin + first_);
    // A little further than the end: outcome_of() compares with the end itself, in doubles.
    VF to = hn::Mul(hn::Load(kF, rays_->end + first_), hn::Set(kF, 1 + kRounding));
    VF largest = zero;
    for (int a = 0; a < 3; ++a) {
      axis_[a].direction = to_floats(load(rays_->direction[a] + first_));
      largest = hn::Max(largest, hn::Abs(axis_[a].direction));
    }
    const VF parallel = hn::Mul(largest, hn::Set(kF, 1e-13f));
    MF still[3];
    for (int a = 0; a < 3; ++a) {
      const VF d = axis_[a].direction;
      still[a] = hn::Le(hn::Abs(d), parallel);
      const Doubles origin = load(rays_->origin[a] + first_);
      const double last = field_->dims[a] - 1;
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
    rest_ = hn::Mul(hn::Set(kF, 4 * kRounding), hn::Add(from_, end_));
    const Doubles from_d = to_doubles(from_);
    for (int a = 0; a < 3; ++a) settle(a, from_d, still[a]);
    undecided_ = hn::FirstN(kF, 0);
    side_ = zero;
    return active;
  }

  // Looks for the surface in a cell of each of these lanes, where it is from t to next_t. Returns
  // the lanes that meet it there, and leaves in `lanes` those that go on.
  HWY_INLINE MF look_in(MF& lanes, const VI (&cell)[3], VF t, VF next_t, Meeting& met) {
    Doubles corner[3];
    for (int a = 0; a < 3; ++a) {
      corner[a] = to_doubles(hn::ConvertTo(kF, cell[a]));
      // A walk that rounding has carried far out may take another block's bits for its own.
      const MI inside = hn::And(hn::Gt(cell[a], hn::Set(kI, -1)),
                                hn::Lt(cell[a], hn::Set(kI, field_->dims[a] - 1)));
      lanes = hn::And(lanes, hn::RebindMask(kF, inside));
    }
    VF c[8];
    Voxels<T, kWide>(*field_, cell, hn::RebindMask(kI, lanes), 0).corners(c);
    for (VF& value : c) value = hn::Sub(value, hn::Set(kF, field_->iso));
    if (field_->iso_rest != 0) {
      for (VF& value : c) value = hn::Sub(value, hn::Set(kF, field_->iso_rest));
    }
    return looked(lanes, piece_in(cell, corner, t, next_t), c, met);
  }

  // The same in one cell for all lanes; `values`: its corners, less the iso value.
  HWY_INLINE MF look_in(MF& lanes, const std::int32_t (&cell)[3], const float (&values)[8], VF t,
                        VF next_t, Meeting& met) {
    VI at[3];
    Doubles corner[3];
    for (int a = 0; a < 3; ++a) {
      at[a] = hn::Set(kI, cell[a]);
      corner[a].low = corner[a].high = hn::Set(kD, static_cast<double>(cell[a]));
    }
    VF c[8];
    for (int n = 0; n < 8; ++n) c[n] = hn::Set(kF, values[n]);
    return looked(lanes, piece_in(at, corner, t, next_t), c, met);
  }

 private:
  HWY_INLINE Piece piece_in(const VI (&cell)[3], const Doubles (&corner)[3], VF t,
                            VF next_t) const {
    Piece piece;
    // Where the walk ends it may still be inside the volume, by a rounding: look a little further.
    const MF leaving = hn::Ge(hn::Add(next_t, rest_), end_);
    piece.t = t;
    piece.span = hn::Add(hn::Sub(next_t, t), hn::IfThenElseZero(leaving, rest_));
    const Doubles along = to_doubles(t);
    for (int a = 0; a < 3; ++a) {
      const Doubles from = load(place_[a]), d = load(direction_[a]);
      piece.cell[a] = cell[a];
      piece.entry[a] =
          to_floats({hn::MulAdd(d.low, along.low, hn::Sub(from.low, corner[a].low)),
                     hn::MulAdd(d.high, along.high, hn::Sub(from.high, corner[a].high))});
      piece.step[a] = hn::Mul(axis_[a].direction, piece.span);
    }
    return piece;
  }

  HWY_INLINE void settle(int a, const Doubles& from, MF still) {
    Axis& axis = axis_[a];
    const Doubles o = load(rays_->origin[a] + first_), d = load(rays_->direction[a] + first_);
    const VD low = hn::MulAdd(d.low, from.low, o.low), high = hn::MulAdd(d.high, from.high, o.high);
    store({low, high}, place_[a]);
    store(d, direction_[a]);
    const std::int32_t last = field_->dims[a] - 2;
    const VI cell = hn::Min(hn::Max(nearest_int(hn::Floor(to_floats({low, high}))), hn::Set(kI, 0)),
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
  }

  HWY_INLINE MF looked(MF& lanes, const Piece& piece, const VF (&c)[8], Meeting& meeting) {
    const MF met = solve(lanes, piece, c, meeting);
    lanes = hn::AndNot(hn::Or(met, undecided_), lanes);
    return met;
  }

  // Looks for the first root in a piece of the active rays; c: the corners, less the iso value.
  HWY_INLINE MF solve(MF active, const Piece& piece, const VF (&c)[8], Meeting& meeting) {
    Cubic p = along(c, piece.entry, piece.step);
    // Turned so that the side where the ray comes from is positive.
    const VF zero = hn::Zero(kF), doubt = hn::Set(kF, field_->doubt);
    const MF fresh = hn::And(active, hn::Eq(side_, zero));
    undecided_ = hn::Or(undecided_, hn::And(fresh, hn::Le(hn::Abs(p.c0), doubt)));
    side_ = hn::IfThenElse(fresh, hn::CopySign(hn::Set(kF, 1.0f), p.c0), side_);
    const VF sign = hn::And(side_, hn::BitCast(kF, hn::Set(kI, INT32_MIN)));
    for (VF* const term : {&p.c0, &p.c1, &p.c2, &p.c3}) *term = hn::Xor(*term, sign);
    undecided_ = hn::Or(undecided_, hn::And(active, hn::Le(p.c0, zero)));

    // By its Bernstein coefficients, without a root where all are positive. With one change of
    // sign among them it has one root.
    const VF third = hn::Set(kF, 1.0f / 3.0f);
    const VF b1 = hn::MulAdd(third, p.c1, p.c0);
    const VF b2 = hn::MulAdd(third, hn::MulAdd(hn::Set(kF, 2.0f), p.c1, p.c2), p.c0);
    const VF b3 = hn::Add(hn::Add(p.c0, p.c1), hn::Add(p.c2, p.c3));
    const MF clear = hn::Gt(hn::Min(hn::Min(p.c0, b1), hn::Min(b2, b3)), doubt);
    MF met = hn::AndNot(hn::Or(clear, undecided_), active);
    if (hn::AllFalse(kF, met)) return met;
    const MF waves = hn::And(hn::Lt(b1, doubt), hn::Gt(b2, hn::Neg(doubt)));
    const MF once = hn::AndNot(waves, hn::Lt(b3, hn::Neg(doubt)));
    VF low = zero, high = hn::Set(kF, 1.0f);
    const MF look = hn::AndNot(once, met);
    if (!hn::AllFalse(kF, look)) {
      const Bracket change = first_change(p, doubt);
      undecided_ = hn::Or(undecided_, hn::And(look, change.undecided));
      met = hn::AndNot(undecided_, hn::And(met, hn::Or(once, change.found)));
      low = hn::IfThenElse(look, change.low, low);
      high = hn::IfThenElse(look, change.high, high);
    }
    meeting.cubic = p;
    meeting.low = low;
    meeting.high = high;
    meeting.piece = piece;
    return met;
  }

 protected:
  const Field* field_;
  Axis axis_[3];
  VI cell_[3];     // where a lane starts, from its base
  VF from_, end_;  // t is counted from `from_`
  VF rest_;        // a rounding of t
  VF side_;        // the field's sign where the ray comes from; 0: not yet known
  MF undecided_;
  // In the volume, where t is 0; of all lanes of the vector.
  alignas(64) double place_[3][RayLanes::kCount / 2], direction_[3][RayLanes::kCount / 2];

 private:
  const RayLanes* rays_;
  std::size_t first_;
};

// The trilinear blend of central differences, carried into world space; and the lanes where it must
// be looked at more closely: at the volume's border, or where it all but vanishes.
template <typename T, bool kWide>
HWY_INLINE void set_normals(const Field& field, const Meeting& at, Outcome& result) {
  MI inner = hn::RebindMask(kI, result.hit);
  for (int a = 0; a < 3; ++a) {
    inner = hn::And(inner, hn::And(hn::Gt(at.piece.cell[a], hn::Zero(kI)),
                                   hn::Lt(at.piece.cell[a], hn::Set(kI, field.dims[a] - 2))));
    result.normal[a] = hn::Zero(kF);
  }
  const MF whole = hn::RebindMask(kF, inner);
  result.without_normal = result.hit;
  if (hn::AllFalse(kF, whole)) return;
  const Voxels<T, kWide> voxels(field, at.piece.cell, inner, 1);
  VF gradient[3], spread = hn::Zero(kF);
  voxels.gradient(result.local, gradient, spread);
  VF n[3];
  VF square = hn::Zero(kF);
  for (int row = 0; row < 3; ++row) {
    const float(&m)[3] = field.world_from_covector[row];
    VF sum = hn::Mul(hn::Set(kF, m[0]), gradient[0]);
    sum = hn::MulAdd(hn::Set(kF, m[1]), gradient[1], sum);
    n[row] = hn::Neg(hn::MulAdd(hn::Set(kF, m[2]), gradient[2], sum));
    square = hn::MulAdd(n[row], n[row], square);
  }
  // The normal is -M^-T g, so its product with the world direction M d is -g . d.
  VF product = hn::Mul(gradient[0], at.direction[0]);
  for (int a = 1; a < 3; ++a) product = hn::MulAdd(gradient[a], at.direction[a], product);
  result.turned = hn::And(whole, hn::Lt(product, hn::Zero(kF)));
  const VF length = hn::Sqrt(square);
  const VF to_origin = hn::IfThenElse(result.turned, hn::Neg(length), length);
  for (int row = 0; row < 3; ++row) result.normal[row] = hn::Div(n[row], to_origin);
  VF longest = hn::Abs(gradient[0]);
  for (int a = 1; a < 3; ++a) longest = hn::Max(longest, hn::Abs(gradient[a]));
  const MF sound =
      hn::And(hn::Gt(longest, hn::Mul(hn::Set(kF, 1e-4f), spread)),
              hn::And(hn::Gt(square, hn::Set(kF, 1e-30f)), hn::Lt(square, hn::Set(kF, 1e30f))));
  result.without_normal = hn::AndNot(hn::And(whole, sound), result.hit);
}

// Where exactly the lanes `met` meet the surface, and whether before the rays' ends; with normals
// on wish.
template <typename T, bool kWide>
HWY_INLINE Outcome outcome_of(const Field& field, MF met, const Meeting& at, VF ends,
                              bool with_normals) {
  Outcome result;
  const VF zero = hn::Zero(kF), one = hn::Set(kF, 1.0f);
  VF value;
  const VF s = zero_between(at.cubic, at.low, at.high, hn::Set(kF, 0.05f * field.doubt), value);
  MF sound = hn::Le(hn::Abs(value), hn::Set(kF, 0.5f * field.doubt));
  // Where the walk began it may still have been outside the volume, by a rounding.
  const VF along = hn::Mul(s, at.piece.span);
  sound = hn::And(sound,
                  hn::Gt(hn::Add(at.piece.t, along), hn::Mul(hn::Set(kF, 4 * kRounding), at.from)));
  // Between two cells the walk's floats may keep to the wrong one for a hair's breadth.
  for (int a = 0; a < 3; ++a) {
    const VF exact = hn::MulAdd(s, at.piece.step[a], at.piece.entry[a]);
    result.local[a] = hn::Min(hn::Max(exact, zero), one);
    sound = hn::And(sound, hn::Le(hn::Abs(hn::Sub(exact, result.local[a])), hn::Set(kF, 5e-7f)));
  }
  const Doubles from = to_doubles(at.from), in = to_doubles(at.piece.t), rest = to_doubles(along);
  result.t = {hn::Add(hn::Add(from.low, in.low), rest.low),
              hn::Add(hn::Add(from.high, in.high), rest.high)};
  result.sound = sound;
  result.hit = hn::And(hn::And(met, sound), is_less(result.t, to_doubles(ends)));
  result.turned = result.without_normal = hn::FirstN(kF, 0);
  if (with_normals) set_normals<T, kWide>(field, at, result);
  return result;
}

}  // namespace isolux::lanes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

#endif
