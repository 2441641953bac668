#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/intersect/lane_walk.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include "isolux/intersect/lane_rays-inl.h"
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

// The lanes of one vector on their way through the volume, each for itself.
template <typename T, bool kWide>
class Walk : public LaneRays<T, kWide> {
  using Base = LaneRays<T, kWide>;
  using Base::axis_;
  using Base::cell_;
  using Base::end_;
  using Base::field_;

 public:
  HWY_INLINE void begin(const Field& field, const RayLanes& rays, std::size_t first,
                        std::uint32_t lanes) {
    active_ = this->start(field, rays, first, lanes);
    walking_ = candidates_ = hn::FirstN(kF, 0);
    t_ = next_t_ = hn::Zero(kF);
    for (int a = 0; a < 3; ++a) next_cell_[a] = hn::Zero(kI);
    const std::int32_t stride[3] = {1, field_->block_stride_y, field_->block_stride_z};
    block_ = octant_bits_ = hn::Zero(kI);
    for (int a = 0; a < 3; ++a) {
      const VI blocks = hn::Add(hn::ShiftRight<2>(axis_[a].base), hn::Set(kI, 1));
      block_ = hn::Add(block_, hn::Mul(blocks, hn::Set(kI, stride[a])));
      const VI down = hn::IfThenZeroElse(hn::RebindMask(kI, axis_[a].up), hn::Set(kI, 4 << a));
      octant_bits_ = hn::Or(octant_bits_, down);
    }
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
        hn::Add(blocks, hn::Mul(hn::ShiftRight<2>(cell_[1]), hn::Set(kI, field_->block_stride_y)));
    blocks =
        hn::Add(blocks, hn::Mul(hn::ShiftRight<2>(cell_[2]), hn::Set(kI, field_->block_stride_z)));
    blocks = hn::Min(hn::Max(blocks, zero), hn::Set(kI, field_->block_count - 1));
    const VI leaps =
        hn::GatherIndex(kI, reinterpret_cast<const std::int32_t*>(field_->leaps), blocks);
    const VI leap = hn::And(hn::Shr(leaps, octant_bits_), hn::Set(kI, 15));
    const MI near = hn::Eq(leap, zero);
    // How far the box reaches that holds nothing: the cube of empty blocks,
    VI keep = hn::Set(kI, ~3);
    VI upper = hn::ShiftLeft<2>(leap);
    VI lower = hn::Sub(hn::Set(kI, 4), upper);
    MF found = hn::FirstN(kF, 0);
    if (!hn::AllFalse(kI, near)) {
      const VI word = hn::Add(hn::Add(blocks, blocks), hn::And(hn::ShiftRight<1>(cell_[2]), one));
      const VI bits =
          hn::GatherIndex(kI, reinterpret_cast<const std::int32_t*>(field_->cells), word);
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
    VI at[3];
    for (int a = 0; a < 3; ++a) at[a] = hn::Add(axis_[a].base, cell_[a]);
    active_ = this->look_in(active_, at, t_, next_t_);
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

 private:
  MF active_;      // have not met the surface yet
  MF walking_;     // of these, the ones on their way to the next cell
  MF candidates_;  // and the ones that stand in it
  VF t_, next_t_;
  VI block_;        // index of the block at the rays' bases
  VI octant_bits_;  // where in a block's leaps those of a lane's octant begin
  VI next_cell_[3];
};

template <typename T, bool kWide>
void walk_all(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes* hits,
              Found& found) {
  const std::size_t step = hn::Lanes(kF);
  const auto mine = [&](std::size_t first) { return lanes >> first & ((1u << step) - 1); };
  // Two vectors at a time, in turn: while one waits for memory, the other computes.
  for (std::size_t first = 0; first < RayLanes::kCount; first += 2 * step) {
    if ((mine(first) | mine(first + step)) == 0) continue;
    Walk<T, kWide> a, b;
    a.begin(field, rays, first, mine(first));
    b.begin(field, rays, first + step, mine(first + step));
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
