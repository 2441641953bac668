#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/intersect/lane_walk.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "isolux/intersect/lane_rays-inl.h"
#include "isolux/intersect/lane_walk.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::lanes::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

// A machine without SSE4: the oracle does everything.
void walk_here(const Field&, std::span<const Question> questions) {
  for (const Question& question : questions) question.found->undecided = question.lanes;
}

#else

constexpr std::size_t kStep = hn::MaxLanes(kF);
constexpr std::uint32_t kAllLanes = (1u << kStep) - 1;

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
    const MF active = this->start(field, rays, first, lanes);
    candidates_ = hn::FirstN(kF, 0);
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
    walking_ = hn::And(active, hn::Lt(t_, end_));
  }

  // Those with somewhere to go; after look() the others are free to take another ray.
  HWY_INLINE std::uint32_t walking() const { return bits_of(walking_); }

  // Lanes take the rays of `other`, each that of lane `which`.
  HWY_INLINE void take(const Walk& other, std::uint32_t lanes, const std::int32_t* which) {
    const MF taken = mask_of(lanes);
    const auto from = hn::SetTableIndices(kF, which);
    const auto take_floats = [&](VF& mine, VF theirs) HWY_ATTR {
      mine = hn::IfThenElse(taken, hn::TableLookupLanes(theirs, from), mine);
    };
    const auto take_integers = [&](VI& mine, VI theirs) HWY_ATTR {
      VF bits = hn::BitCast(kF, mine);
      take_floats(bits, hn::BitCast(kF, theirs));
      mine = hn::BitCast(kI, bits);
    };
    for (int a = 0; a < 3; ++a) {
      Axis& axis = axis_[a];
      take_floats(axis.direction, other.axis_[a].direction);
      take_floats(axis.cell_origin, other.axis_[a].cell_origin);
      take_floats(axis.inverse, other.axis_[a].inverse);
      take_floats(axis.offset, other.axis_[a].offset);
      axis.up = hn::Gt(axis.direction, hn::Zero(kF));
      take_integers(axis.base, other.axis_[a].base);
      take_integers(cell_[a], other.cell_[a]);
    }
    take_floats(Base::from_, other.from_);
    take_floats(end_, other.end_);
    take_floats(Base::rest_, other.rest_);
    take_integers(block_, other.block_);
    take_integers(octant_bits_, other.octant_bits_);
    Base::side_ = hn::IfThenZeroElse(taken, Base::side_);
    t_ = hn::IfThenZeroElse(taken, t_);
    walking_ = hn::Or(walking_, taken);
    for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
      const int to = std::countr_zero(rest);
      for (int a = 0; a < 3; ++a) {
        Base::place_[a][to] = other.place_[a][which[to]];
        Base::direction_[a][to] = other.direction_[a][which[to]];
      }
    }
  }

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
    if constexpr (kWide) {  // a smaller volume is in the caches mostly
      VI at[3];
      for (int a = 0; a < 3; ++a) at[a] = hn::Add(axis_[a].base, cell_[a]);
      fetch_rows<T>(*field_, at, bits_of(found), kCornerRows);
    }
    next_t_ = hn::IfThenElse(found, next_t, next_t_);
    t_ = hn::IfThenElse(hn::RebindMask(kF, go), next_t, t_);
    candidates_ = hn::Or(candidates_, found);
    walking_ = hn::And(hn::AndNot(found, walking_), hn::Lt(t_, end_));
  }

  // Looks for the surface in the cells where lanes have stopped. Returns those that meet it there;
  // `undecided` are those of which the oracle must tell. The others go on.
  HWY_INLINE MF look(Meeting& met, std::uint32_t& undecided) {
    undecided = 0;
    MF onward = candidates_;
    if (hn::AllFalse(kF, onward)) return onward;
    candidates_ = hn::FirstN(kF, 0);
    VI at[3];
    for (int a = 0; a < 3; ++a) at[a] = hn::Add(axis_[a].base, cell_[a]);
    const MF meets = this->look_in(onward, at, t_, next_t_, met);
    met.from = Base::from_;
    for (int a = 0; a < 3; ++a) met.direction[a] = axis_[a].direction;
    undecided = bits_of(Base::undecided_);
    Base::undecided_ = candidates_;
    // Past the cell that was looked at in vain.
    t_ = hn::IfThenElse(onward, next_t_, t_);
    for (int a = 0; a < 3; ++a) {
      cell_[a] = hn::IfThenElse(hn::RebindMask(kI, onward), next_cell_[a], cell_[a]);
    }
    walking_ = hn::Or(walking_, hn::And(onward, hn::Lt(t_, end_)));
    return meets;
  }

 private:
  MF walking_;     // on their way to the next cell
  MF candidates_;  // or standing in it
  VF t_, next_t_;
  VI block_;        // index of the block at the rays' bases
  VI octant_bits_;  // where in a block's leaps those of a lane's octant begin
  VI next_cell_[3];
};

// Rays that have met the surface, until there is a vector of them.
class Meetings {
 public:
  HWY_INLINE void add(const Meeting& met, MF lanes, const std::uint32_t* rays) {
    const auto add_one = [&](VF value, int field)
                             HWY_ATTR { hn::CompressStore(value, lanes, kF, at_[field] + count_); };
    each_field(met, add_one);
    for (std::uint32_t rest = bits_of(lanes); rest != 0; rest &= rest - 1) {
      rays_[count_++] = rays[std::countr_zero(rest)];
    }
  }
  std::size_t count() const { return std::min(count_, kStep); }
  bool is_vector() const { return count_ >= kStep; }
  std::uint32_t ray(std::size_t n) const { return rays_[n]; }

  HWY_INLINE void get(Meeting& met) const {
    each_field(met, [&](VF& value, int field) HWY_ATTR { value = hn::Load(kF, at_[field]); });
  }
  HWY_INLINE void drop() {
    count_ -= count();
    for (auto& field : at_) hn::Store(hn::LoadU(kF, field + kStep), kF, field);
    std::copy_n(rays_ + kStep, kStep, rays_);
  }

 private:
  static constexpr int kFields = 21;

  template <typename M, typename Body>
  static HWY_INLINE void each_field(M& met, const Body& body) {
    body(met.cubic.c0, 0);
    body(met.cubic.c1, 1);
    body(met.cubic.c2, 2);
    body(met.cubic.c3, 3);
    body(met.low, 4);
    body(met.high, 5);
    body(met.piece.t, 6);
    body(met.piece.span, 7);
    body(met.from, 8);
    for (int a = 0; a < 3; ++a) {
      body(met.piece.entry[a], 9 + a);
      body(met.piece.step[a], 12 + a);
      body(met.direction[a], 15 + a);
      VF cell = hn::BitCast(kF, met.piece.cell[a]);
      body(cell, 18 + a);
      if constexpr (!std::is_const_v<M>) met.piece.cell[a] = hn::BitCast(kI, cell);
    }
  }

  alignas(64) float at_[kFields][2 * kStep] = {};
  std::uint32_t rays_[2 * kStep] = {};
  std::size_t count_ = 0;
};

// All rays of the questions, in their order, through two vectors that go in turn: while one waits
// for memory, the other computes. A lane that is through takes the next ray.
template <typename T, bool kWide>
class Stream {
 public:
  HWY_INLINE Stream(const Field& field, std::span<const Question> questions)
      : field_(field), questions_(questions) {}

  HWY_INLINE void run() {
    for (int n = 0; n < 2; ++n) begin(n);
    while (true) {
      for (int n = 0; n < 2; ++n) {
        if (!is_busy(walks_[n])) look(n);
      }
      const bool both = walks_[0].walking() != 0 && walks_[1].walking() != 0;
      if (both) {
        do {
          walks_[0].step();
          walks_[1].step();
        } while (is_busy(walks_[0]) && is_busy(walks_[1]));
        continue;
      }
      Walk<T, kWide>& last = walks_[walks_[0].walking() != 0 ? 0 : 1];
      if (last.walking() == 0) break;
      do last.step();
      while (is_busy(last));
    }
    while (meetings_.count() != 0) tell();
  }

 private:
  // With fewer lanes walking, others look and begin first.
  static constexpr int kBusy = kStep / 2;

  HWY_INLINE bool is_busy(const Walk<T, kWide>& walk) const {
    return std::popcount(walk.walking()) >= (is_more_ || fresh_lanes_ != 0 ? kBusy : 1);
  }

  HWY_INLINE void look(int n) {
    Meeting met;
    std::uint32_t undecided;
    const MF meets = walks_[n].look(met, undecided);
    for (; undecided != 0; undecided &= undecided - 1) {
      const std::uint32_t ray = rays_[n][std::countr_zero(undecided)];
      questions_[ray / RayLanes::kCount].found->undecided |= 1u << ray % RayLanes::kCount;
    }
    if (!hn::AllFalse(kF, meets)) {
      meetings_.add(met, meets, rays_[n]);
      if constexpr (kWide) fetch_rows<T>(field_, met.piece.cell, bits_of(meets), kRowsAround);
      if (meetings_.is_vector()) tell();
    }
    refill(n);
  }

  bool with_normals() const { return questions_[0].hits != nullptr; }

  // Lanes that are through take the next rays.
  HWY_INLINE void refill(int n) {
    std::uint32_t idle = kAllLanes & ~walks_[n].walking();
    while (idle != 0 && (fresh_lanes_ != 0 || is_more_)) {
      if (fresh_lanes_ == 0) {
        fresh_first_ = start(fresh_);
        fresh_lanes_ = fresh_.walking();
        continue;
      }
      alignas(64) std::int32_t which[kStep] = {};
      std::uint32_t taken = 0;
      for (; idle != 0 && fresh_lanes_ != 0; idle &= idle - 1, fresh_lanes_ &= fresh_lanes_ - 1) {
        const int to = std::countr_zero(idle), from = std::countr_zero(fresh_lanes_);
        which[to] = from;
        taken |= 1u << to;
        rays_[n][to] = fresh_first_ + static_cast<std::uint32_t>(from);
      }
      walks_[n].take(fresh_, taken, which);
    }
  }

  // Starts the next rays in the lanes of a vector, or none; returns the ray of the first lane.
  HWY_INLINE std::uint32_t start(Walk<T, kWide>& walk) {
    const std::size_t end = questions_.size() * RayLanes::kCount;
    const auto lanes = [&] {
      return questions_[next_ / RayLanes::kCount].lanes >> next_ % RayLanes::kCount & kAllLanes;
    };
    while (next_ != end && lanes() == 0) next_ += kStep;
    is_more_ = next_ != end;
    const std::size_t at = is_more_ ? next_ : 0;
    walk.begin(field_, *questions_[at / RayLanes::kCount].rays, at % RayLanes::kCount,
               is_more_ ? lanes() : 0);
    if (is_more_) next_ += kStep;
    is_more_ = next_ != end;
    return static_cast<std::uint32_t>(at);
  }

  HWY_INLINE void begin(int n) {
    const std::uint32_t first = start(walks_[n]);
    for (std::uint32_t lane = 0; lane < kStep; ++lane) rays_[n][lane] = first + lane;
  }

  // What came of the rays that met the surface, as many as there are lanes.
  HWY_INLINE void tell() {
    Meeting met;
    meetings_.get(met);
    const std::size_t count = meetings_.count();
    alignas(64) float ends[kStep] = {};
    for (std::size_t n = 0; n < count; ++n) {
      const std::uint32_t ray = meetings_.ray(n);
      ends[n] = questions_[ray / RayLanes::kCount].rays->end[ray % RayLanes::kCount];
    }
    const Outcome is = outcome_of<T, kWide>(field_, hn::FirstN(kF, count), met, hn::Load(kF, ends),
                                            with_normals());
    const std::uint32_t sound = bits_of(is.sound), hit = bits_of(is.hit),
                        turned = bits_of(is.turned), without = bits_of(is.without_normal);
    alignas(64) double t[kStep];
    alignas(64) float local[3][kStep], normal[3][kStep];
    alignas(64) std::int32_t cell[3][kStep];
    if (with_normals()) {
      store(is.t, t);
      for (int a = 0; a < 3; ++a) {
        hn::Store(is.local[a], kF, local[a]);
        hn::Store(is.normal[a], kF, normal[a]);
        hn::Store(met.piece.cell[a], kI, cell[a]);
      }
    }
    for (std::size_t n = 0; n < count; ++n) {
      const std::uint32_t ray = meetings_.ray(n);
      const Question& question = questions_[ray / RayLanes::kCount];
      const std::uint32_t lane = ray % RayLanes::kCount, bit = 1u << lane;
      Found& found = *question.found;
      if (!(sound >> n & 1)) found.undecided |= bit;
      if (!(hit >> n & 1)) continue;
      found.hit |= bit;
      if (!with_normals()) continue;
      question.hits->t[lane] = t[n];
      for (int a = 0; a < 3; ++a) question.hits->normal[a][lane] = normal[a][n];
      if (turned >> n & 1) found.turned |= bit;
      if (!(without >> n & 1)) continue;
      found.without_normal |= bit;
      for (int a = 0; a < 3; ++a) {
        found.cell[a][lane] = cell[a][n];
        found.local[a][lane] = local[a][n];
      }
    }
    meetings_.drop();
  }

  const Field& field_;
  std::span<const Question> questions_;
  Walk<T, kWide> walks_[2];
  std::uint32_t rays_[2][kStep];   // which one each lane has: a question's number, a lane's in it
  Walk<T, kWide> fresh_;           // those that are to be taken next,
  std::uint32_t fresh_lanes_ = 0;  // these of its lanes,
  std::uint32_t fresh_first_ = 0;  // from this ray on
  std::size_t next_ = 0;           // the first ray of the next vector
  bool is_more_ = true;
  Meetings meetings_;
};

void walk_here(const Field& field, std::span<const Question> questions) {
  const auto with = [&]<typename T>(T) {
    field.is_wide ? Stream<T, true>(field, questions).run()
                  : Stream<T, false>(field, questions).run();
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

void walk(const Field& field, std::span<const Question> questions) {
  HWY_DYNAMIC_DISPATCH(walk_here)(field, questions);
}

}  // namespace isolux::lanes
#endif
