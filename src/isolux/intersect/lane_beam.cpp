#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/intersect/lane_beam.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "isolux/intersect/lane_rays-inl.h"
#include "isolux/intersect/lane_walk.h"

#ifndef ISOLUX_INTERSECT_LANE_BEAM_BITS
#define ISOLUX_INTERSECT_LANE_BEAM_BITS
namespace isolux::lanes {

// The cells of a block, a bit each, whose place along an axis is one of a set of four bits.
struct CellsAt {
  std::uint64_t cells[3][16];

  constexpr CellsAt() : cells{} {
    for (int axis = 0; axis < 3; ++axis) {
      for (int cell = 0; cell < 64; ++cell) {
        const int place = cell >> (2 * axis) & 3;
        for (int set = 0; set < 16; ++set) {
          if (set >> place & 1) cells[axis][set] |= std::uint64_t{1} << cell;
        }
      }
    }
  }
};
inline constexpr CellsAt kCellsAt;

// A block's bits with the cells in reverse order along the axes whose bit is set in `axes`.
inline std::uint64_t reversed(std::uint64_t cells, unsigned axes) {
  const auto swap = [&](int by, std::uint64_t low) {
    cells = (cells >> by & low) | (cells & low) << by;
  };
  if (axes & 1) {
    swap(1, 0x5555555555555555);
    swap(2, 0x3333333333333333);
  }
  if (axes & 2) {
    swap(4, 0x0F0F0F0F0F0F0F0F);
    swap(8, 0x00FF00FF00FF00FF);
  }
  if (axes & 4) {
    swap(16, 0x0000FFFF0000FFFF);
    swap(32, 0x00000000FFFFFFFF);
  }
  return cells;
}

}  // namespace isolux::lanes
#endif

HWY_BEFORE_NAMESPACE();
namespace isolux::lanes::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

void walk_beam_here(const Field&, const RayLanes&, std::uint32_t lanes, HitLanes*, Found& found) {
  found.undecided = lanes;
}

#else

constexpr float kSlack = 4e-3f;  // of a cell: more than the floats below lose

// The places of a block's four slabs along the major axis.
constexpr hn::CappedTag<float, 4> kSlabF;
constexpr hn::RebindToSigned<decltype(kSlabF)> kSlabI;
using SlabF = hn::Vec<decltype(kSlabF)>;
using SlabI = hn::Vec<decltype(kSlabI)>;

// Where all rays of a beam are along an axis when they are at a place of the major axis, counted
// from where the beam begins: linear bounds.
struct Side {
  float low, low_rise, high, high_rise;

  // The cells that the rays can pass while the major axis runs from `from` to `from` + size.
  template <class V, class DF = hn::DFromV<V>, class VInt = hn::Vec<hn::RebindToSigned<DF> > >
  HWY_INLINE void cells(V from, float size, std::int32_t count, VInt& first, VInt& last) const {
    const DF d;
    const hn::RebindToSigned<DF> di;
    // The whole number below is the one nearest to half a cell less; the slack is more than a tie.
    const float least = low + std::min(0.0f, size * low_rise) - kSlack - 0.5f;
    const float most = high + std::max(0.0f, size * high_rise) + kSlack - 0.5f;
    first = nearest_int(hn::MulAdd(from, hn::Set(d, low_rise), hn::Set(d, least)));
    last = nearest_int(hn::MulAdd(from, hn::Set(d, high_rise), hn::Set(d, most)));
    first = hn::Max(first, hn::Zero(di));
    last = hn::Min(last, hn::Set(di, count - 1));
  }
};

// For each slab, which of a block's four places along an axis are between two cells.
HWY_INLINE SlabI places_between(SlabI first, SlabI last, std::int32_t block) {
  const SlabI corner = hn::Set(kSlabI, 4 * block), all = hn::Set(kSlabI, 15);
  const SlabI low = hn::Min(hn::Max(hn::Sub(first, corner), hn::Zero(kSlabI)), hn::Set(kSlabI, 4));
  const SlabI above =
      hn::Min(hn::Max(hn::Sub(hn::Set(kSlabI, 3), hn::Sub(last, corner)), hn::Zero(kSlabI)),
              hn::Set(kSlabI, 4));
  return hn::And(hn::Shl(all, low), hn::Shr(all, above));
}

// The rays of one vector, as a beam sees them.
template <typename T, bool kWide>
class BeamLanes : public LaneRays<T, kWide> {
  using Base = LaneRays<T, kWide>;
  using Base::axis_;
  using Base::cell_;
  using Base::end_;
  using Base::field_;

 public:
  HWY_INLINE void begin(const Field& field, const RayLanes& rays, std::size_t first,
                        std::uint32_t lanes) {
    unchosen_ = this->start(field, rays, first, lanes);
    rays_ = &rays;
    first_ = first;
    met_lanes_ = hn::FirstN(kF, 0);
    forget();
    for (int a = 0; a < 3; ++a) {
      base_[a] = hn::ConvertTo(kF, axis_[a].base);
      still_[a] = hn::Eq(axis_[a].direction, hn::Zero(kF));
      has_still_[a] = !hn::AllFalse(kF, hn::And(still_[a], unchosen_));
    }
  }
  // Lanes that have not been chosen yet.
  HWY_INLINE std::uint32_t rest() const { return bits_of(unchosen_); }

  // The way of each lane: the axis along which it runs most, and the signs of its direction.
  HWY_INLINE VI ways() const {
    const VF x = hn::Abs(axis_[0].direction), y = hn::Abs(axis_[1].direction),
             z = hn::Abs(axis_[2].direction);
    const MF is_x = hn::And(hn::Ge(x, y), hn::Ge(x, z));
    const VI major = hn::IfThenElse(
        hn::RebindMask(kI, is_x), hn::Zero(kI),
        hn::IfThenElse(hn::RebindMask(kI, hn::Ge(y, z)), hn::Set(kI, 1), hn::Set(kI, 2)));
    VI way = hn::ShiftLeft<3>(major);
    for (int a = 0; a < 3; ++a) {
      const VI down = hn::IfThenElseZero(
          hn::RebindMask(kI, hn::Lt(axis_[a].direction, hn::Zero(kF))), hn::Set(kI, 1 << a));
      way = hn::Or(way, down);
    }
    return way;
  }
  // Takes the lanes that run this way.
  HWY_INLINE void choose(std::int32_t way) {
    left_ = hn::And(unchosen_, hn::RebindMask(kF, hn::Eq(ways(), hn::Set(kI, way))));
    unchosen_ = hn::AndNot(left_, unchosen_);
  }
  HWY_INLINE bool is_left() const { return !hn::AllFalse(kF, left_); }

  // Where the chosen lanes begin and end along an axis.
  HWY_INLINE VF place_at_begin(int a) const { return hn::Add(base_[a], axis_[a].origin); }
  HWY_INLINE VF place_at_end(int a) const {
    return hn::MulAdd(axis_[a].direction, end_, place_at_begin(a));
  }
  // Where they are along axis a when at `plane` of the major axis.
  HWY_INLINE VF place_at(int a, int major, float plane) const {
    const VF rise = hn::Mul(axis_[a].direction, axis_[major].inverse);
    return hn::MulAdd(rise, hn::Sub(hn::Set(kF, plane), place_at_begin(major)), place_at_begin(a));
  }
  HWY_INLINE VF or_else(VF value, float otherwise) const {
    return hn::IfThenElse(left_, value, hn::Set(kF, otherwise));
  }

  // Makes ready for the cells of a block; false where no lane is left.
  HWY_INLINE bool enter_block(const std::int32_t (&block)[3], unsigned down) {
    if (!is_left()) return false;
    for (int a = 0; a < 3; ++a) {
      const Axis& axis = axis_[a];
      const bool is_down = down >> a & 1;
      const std::int32_t last = field_->dims[a] - 1, first_plane = 4 * block[a] + (is_down ? 4 : 0);
      const VF step = hn::Set(kF, is_down ? -1.0f : 1.0f);
      VF plane = hn::Sub(hn::Set(kF, static_cast<float>(first_plane)), base_[a]);
      for (VF& t : planes_[a]) {
        t = hn::MulAdd(plane, axis.inverse, axis.offset);
        if (has_still_[a]) {
          const MF is_before = hn::Le(plane, hn::ConvertTo(kF, cell_[a]));
          const VF never = hn::CopySign(
              hn::Set(kF, 1e30f), hn::IfThenElse(is_before, hn::Set(kF, -1.0f), hn::Set(kF, 1.0f)));
          t = hn::IfThenElse(still_[a], never, t);
        }
        plane = hn::Add(plane, step);
      }
      // At the volume's border a walk may begin and end a rounding further out.
      const std::int32_t to_low = is_down ? first_plane : -first_plane;
      const std::int32_t to_high = is_down ? first_plane - last : last - first_plane;
      const std::int32_t in = is_down ? to_high : to_low, out = is_down ? to_low : to_high;
      if (in >= 0 && in <= 4) planes_[a][in] = hn::Set(kF, -1e30f);
      if (out >= 0 && out <= 4) planes_[a][out] = hn::Set(kF, 1e30f);
    }
    return true;
  }
  // In a row of the block's cells, counted as the lanes run; false where no lane passes through it.
  HWY_INLINE bool enter_row(int y, int z) {
    row_t_ = hn::Max(hn::Max(planes_[1][y], planes_[2][z]), hn::Zero(kF));
    row_next_t_ = hn::Min(hn::Min(planes_[1][y + 1], planes_[2][z + 1]), end_);
    in_row_ = hn::And(left_, hn::Lt(row_t_, row_next_t_));
    return !hn::AllFalse(kF, in_row_);
  }
  // In a cell of that row.
  HWY_INLINE bool enter_cell(int x) {
    t_ = hn::Max(row_t_, planes_[0][x]);
    next_t_ = hn::Min(row_next_t_, planes_[0][x + 1]);
    in_cell_ = hn::And(hn::And(in_row_, left_), hn::Lt(t_, next_t_));
    return !hn::AllFalse(kF, in_cell_);
  }
  HWY_INLINE void look(const std::int32_t (&cell)[3], const float (&values)[8]) {
    MF on = in_cell_;
    Meeting meeting;
    const MF met = this->look_in(on, cell, values, t_, next_t_, meeting);
    left_ = hn::Or(hn::AndNot(in_cell_, left_), on);
    if (!hn::AllFalse(kF, met)) keep(met, meeting);
  }

  HWY_INLINE void end(HitLanes* hits, Found& found) {
    const MF undecided = Base::undecided_;
    if (hn::AllFalse(kF, hn::Or(met_lanes_, undecided))) return;
    met_.from = Base::from_;
    for (int a = 0; a < 3; ++a) met_.direction[a] = axis_[a].direction;
    const Outcome is = outcome_of<T, kWide>(*field_, met_lanes_, met_,
                                            hn::Load(kF, rays_->end + first_), hits != nullptr);
    found.undecided |= bits_of(hn::Or(undecided, hn::AndNot(is.sound, met_lanes_))) << first_;
    found.hit |= bits_of(is.hit) << first_;
    if (!hits) return;
    store(is.t, hits->t + first_);
    for (int a = 0; a < 3; ++a) {
      hn::Store(met_.piece.cell[a], kI, found.cell[a] + first_);
      hn::Store(is.local[a], kF, found.local[a] + first_);
      hn::Store(is.normal[a], kF, hits->normal[a] + first_);
    }
    found.turned |= bits_of(is.turned) << first_;
    found.without_normal |= bits_of(is.without_normal) << first_;
  }

 private:
  HWY_INLINE void forget() {
    const VF zero = hn::Zero(kF);
    met_.cubic = {zero, zero, zero, zero};
    met_.low = met_.high = met_.piece.t = met_.piece.span = zero;
    for (int a = 0; a < 3; ++a) {
      met_.piece.entry[a] = met_.piece.step[a] = zero;
      met_.piece.cell[a] = hn::Zero(kI);
    }
  }
  HWY_INLINE void keep(MF lanes, const Meeting& meeting) {
    met_lanes_ = hn::Or(met_lanes_, lanes);
    const auto take = [lanes](VF value, VF& place)
                          HWY_ATTR { place = hn::IfThenElse(lanes, value, place); };
    take(meeting.cubic.c0, met_.cubic.c0);
    take(meeting.cubic.c1, met_.cubic.c1);
    take(meeting.cubic.c2, met_.cubic.c2);
    take(meeting.cubic.c3, met_.cubic.c3);
    take(meeting.low, met_.low);
    take(meeting.high, met_.high);
    take(meeting.piece.t, met_.piece.t);
    take(meeting.piece.span, met_.piece.span);
    for (int a = 0; a < 3; ++a) {
      take(meeting.piece.entry[a], met_.piece.entry[a]);
      take(meeting.piece.step[a], met_.piece.step[a]);
      met_.piece.cell[a] =
          hn::IfThenElse(hn::RebindMask(kI, lanes), meeting.piece.cell[a], met_.piece.cell[a]);
    }
  }

  const RayLanes* rays_;
  std::size_t first_;
  VF base_[3];
  MF still_[3];
  bool has_still_[3];
  MF unchosen_, left_;
  VF planes_[3][5];  // t of a block's planes, in the order of the lanes' way
  MF in_row_, in_cell_;
  VF row_t_, row_next_t_, t_, next_t_;
  MF met_lanes_;
  Meeting met_;  // of these
};

// All lanes, where they run much the same way: the blocks that any of them can pass are looked up
// one after the other, for all of them together, and then the blocks' marked cells.
template <typename T, bool kWide>
class Beam {
 public:
  HWY_INLINE Beam(const Field& field, const RayLanes& rays, std::uint32_t lanes) : field_(field) {
    for (std::size_t n = 0; n < kVectors; ++n) {
      rays_[n].begin(field, rays, n * kStep, lanes >> (n * kStep) & kMask);
    }
  }

  // Takes the lanes that run the same way together; nearly always that is all.
  HWY_INLINE void run() {
    for (std::size_t n = 0; n < kVectors; ++n) {
      while (const std::uint32_t rest = rays_[n].rest()) {
        alignas(64) std::int32_t way[kStep];
        hn::Store(rays_[n].ways(), kI, way);
        pass(way[std::countr_zero(rest)]);
      }
    }
  }

  HWY_INLINE void end(HitLanes* hits, Found& found) {
    for (auto& rays : rays_) rays.end(hits, found);
  }

 private:
  static constexpr std::size_t kStep = hn::MaxLanes(kF);
  static constexpr std::size_t kVectors = RayLanes::kCount / kStep;
  static constexpr std::uint32_t kMask = (1u << kStep) - 1;

  HWY_INLINE bool is_left() const {
    bool any = false;
    for (const auto& rays : rays_) any |= rays.is_left();
    return any;
  }

  template <typename Place>
  HWY_INLINE float least(const Place& place) const {
    VF least = hn::Set(kF, 1e30f);
    for (const auto& rays : rays_) least = hn::Min(least, rays.or_else(place(rays), 1e30f));
    return hn::GetLane(hn::MinOfLanes(kF, least));
  }
  template <typename Place>
  HWY_INLINE float greatest(const Place& place) const {
    VF greatest = hn::Set(kF, -1e30f);
    for (const auto& rays : rays_) greatest = hn::Max(greatest, rays.or_else(place(rays), -1e30f));
    return hn::GetLane(hn::MaxOfLanes(kF, greatest));
  }

  // Where lines go that run the same way: the least of many linear functions lies above the line
  // through its values at two places, and the greatest below.
  HWY_INLINE Side side_of(int a) const {
    const auto at_begin = [&](const auto& rays)
                              HWY_ATTR { return rays.place_at(a, major_, begin_); };
    const auto at_end = [&](const auto& rays) HWY_ATTR { return rays.place_at(a, major_, reach_); };
    const float length = reach_ - begin_;
    const float low = least(at_begin), high = greatest(at_begin);
    return {low, (least(at_end) - low) / length, high, (greatest(at_end) - high) / length};
  }

  // Takes the lanes that run this way through the volume.
  HWY_INLINE void pass(std::int32_t way) {
    for (auto& rays : rays_) rays.choose(way);
    down_ = static_cast<unsigned>(way & 7);
    major_ = way >> 3;
    const int u = major_ == 0 ? 1 : 0, v = major_ == 2 ? 1 : 2;
    const bool is_down = down_ >> major_ & 1;
    const auto from = [&](const auto& rays) HWY_ATTR { return rays.place_at_begin(major_); };
    const auto to = [&](const auto& rays) HWY_ATTR { return rays.place_at_end(major_); };
    begin_ = is_down ? greatest(from) : least(from);
    reach_ = is_down ? std::min(least(to), begin_ - 1) : std::max(greatest(to), begin_ + 1);
    const Side along_u = side_of(u), along_v = side_of(v);

    const std::int32_t blocks = (field_.dims[major_] + 2) >> 2;
    const std::int32_t stride[3] = {1, field_.block_stride_y, field_.block_stride_z};
    const auto block_at = [&](float place) {
      return std::clamp(static_cast<std::int32_t>(place) >> 2, 0, blocks - 1);
    };
    const std::int32_t last = block_at(reach_ + (is_down ? -kSlack : kSlack));
    std::int32_t block[3];
    block[major_] = block_at(begin_ + (is_down ? kSlack : -kSlack));
    const bool is_down_u = down_ >> u & 1, is_down_v = down_ >> v & 1;
    while (true) {
      const float from = static_cast<float>(4 * block[major_]) - begin_;
      const auto first_and_last = [&](const Side& side, int a, std::int32_t& first,
                                      std::int32_t& last) HWY_ATTR {
        constexpr hn::CappedTag<float, 1> one;
        hn::Vec<hn::RebindToSigned<decltype(one)> > low, high;
        side.cells(hn::Set(one, from), 4, field_.dims[a] - 1, low, high);
        first = hn::GetLane(low);
        last = hn::GetLane(high);
      };
      std::int32_t u0, u1, v0, v1;
      first_and_last(along_u, u, u0, u1);
      first_and_last(along_v, v, v0, v1);
      std::int32_t leap = SkipGrid::kGreatestLeap;
      if (u0 <= u1 && v0 <= v1) {
        u0 >>= 2, u1 >>= 2, v0 >>= 2, v1 >>= 2;
        const std::int32_t layer =
            1 + field_.block_stride_y + field_.block_stride_z + block[major_] * stride[major_];
        bool has_cells = false;
        SlabI slab_u[2], slab_v[2];
        for (std::int32_t n = v0; n <= v1; ++n) {
          block[v] = is_down_v ? v1 + v0 - n : n;
          for (std::int32_t m = u0; m <= u1; ++m) {
            block[u] = is_down_u ? u1 + u0 - m : m;
            const std::int32_t at = layer + block[u] * stride[u] + block[v] * stride[v];
            const auto free = static_cast<std::int32_t>(field_.leaps[at] >> (4 * down_) & 15);
            leap = std::min(leap, free);
            if (free != 0) continue;
            if (!has_cells) {
              has_cells = true;
              const SlabF slabs = hn::Add(hn::Set(kSlabF, from), hn::Iota(kSlabF, 0.0f));
              along_u.cells(slabs, 1, field_.dims[u] - 1, slab_u[0], slab_u[1]);
              along_v.cells(slabs, 1, field_.dims[v] - 1, slab_v[0], slab_v[1]);
            }
            alignas(16) std::int32_t set_u[4], set_v[4];
            hn::Store(places_between(slab_u[0], slab_u[1], block[u]), kSlabI, set_u);
            hn::Store(places_between(slab_v[0], slab_v[1], block[v]), kSlabI, set_v);
            std::uint64_t cells = 0;
            for (int slab = 0; slab < 4; ++slab) {
              cells |= kCellsAt.cells[major_][1 << slab] & kCellsAt.cells[u][set_u[slab]] &
                       kCellsAt.cells[v][set_v[slab]];
            }
            std::uint64_t marked;
            std::memcpy(&marked, field_.cells + 2 * static_cast<std::ptrdiff_t>(at), sizeof marked);
            if ((cells & marked) != 0) pass_block(block, cells & marked);
          }
        }
        if (has_cells && !is_left()) return;
      }
      const std::int32_t step = std::max(leap, 1);
      block[major_] += is_down ? -step : step;
      if (is_down ? block[major_] < last : block[major_] > last) return;
    }
  }

  // Some cells of a block, in the order in which any ray of the beam passes them.
  HWY_INLINE void pass_block(const std::int32_t (&block)[3], std::uint64_t cells) {
    fetch_rows(block, cells);
    bool is_here[kVectors], in_row[kVectors] = {};
    for (std::size_t i = 0; i < kVectors; ++i) is_here[i] = rays_[i].enter_block(block, down_);
    const int flip = (down_ & 1 ? 3 : 0) | (down_ & 2 ? 12 : 0) | (down_ & 4 ? 48 : 0);
    int row = -1;
    for (cells = reversed(cells, down_); cells != 0; cells &= cells - 1) {
      const int place = std::countr_zero(cells);
      if (place >> 2 != row) {
        row = place >> 2;
        bool any = false;
        for (std::size_t i = 0; i < kVectors; ++i) {
          in_row[i] = is_here[i] && rays_[i].enter_row(row & 3, row >> 2);
          any |= in_row[i];
        }
        if (!any) {
          cells &= ~(std::uint64_t{15} << (4 * row)) | std::uint64_t{1} << place;
          continue;
        }
      }
      const int n = place ^ flip;
      const std::int32_t cell[3] = {4 * block[0] + (n & 3), 4 * block[1] + (n >> 2 & 3),
                                    4 * block[2] + (n >> 4)};
      bool is_read = false;
      alignas(32) float values[8];
      for (std::size_t i = 0; i < kVectors; ++i) {
        if (!in_row[i] || !rays_[i].enter_cell(place & 3)) continue;
        if (!is_read) read_corners(cell, values);
        is_read = true;
        rays_[i].look(cell, values);
      }
    }
  }

  // Asks for the voxels of these cells, so that they are there when their turn comes.
  HWY_INLINE void fetch_rows(const std::int32_t (&block)[3], std::uint64_t cells) const {
    const std::ptrdiff_t row = field_.dims[0], slice = row * field_.dims[1];
    const T* corner = static_cast<const T*>(field_.voxels) + 4 * block[0] + row * (4 * block[1]) +
                      slice * (4 * block[2]);
    std::uint64_t rows = (cells | cells >> 1 | cells >> 2 | cells >> 3) & 0x1111111111111111;
    while (rows != 0) {
      const int place = std::countr_zero(rows) >> 2;
      rows &= rows - 1;
      const T* first = corner + (place & 3) * row + (place >> 2) * slice;
      for (const std::ptrdiff_t at : {std::ptrdiff_t{0}, row, slice, slice + row}) {
        hwy::Prefetch(first + at);
      }
    }
  }

  // The values at a cell's corners, less the iso value.
  HWY_INLINE void read_corners(const std::int32_t (&cell)[3], float (&values)[8]) const {
    const std::ptrdiff_t row = field_.dims[0], slice = row * field_.dims[1];
    const T* from =
        static_cast<const T*>(field_.voxels) + cell[0] + row * cell[1] + slice * cell[2];
    alignas(16) T voxels[8];
    for (int edge = 0; edge < 4; ++edge) {
      std::memcpy(voxels + 2 * edge, from + (edge & 1) * row + (edge >> 1) * slice, 2 * sizeof(T));
    }
    constexpr hn::CappedTag<float, 8> kEight;
    for (std::size_t n = 0; n < 8; n += hn::Lanes(kEight)) {
      const auto differences = hn::Sub(floats(kEight, voxels + n), hn::Set(kEight, field_.iso));
      hn::Store(hn::Sub(differences, hn::Set(kEight, field_.iso_rest)), kEight, values + n);
    }
  }

  template <class D>
  static HWY_INLINE hn::Vec<D> floats(D d, const T* voxels) {
    if constexpr (std::is_same_v<T, float>) {
      return hn::LoadU(d, voxels);
    } else {
      const hn::RebindToSigned<D> integers;
      return hn::ConvertTo(d, hn::PromoteTo(integers, hn::LoadU(hn::Rebind<T, D>(), voxels)));
    }
  }

  const Field& field_;
  BeamLanes<T, kWide> rays_[kVectors];
  unsigned down_ = 0;  // a bit for each axis along which the lanes run towards lower indices
  int major_ = 0;
  float begin_ = 0, reach_ = 0;  // where the lanes run, along the major axis
};

template <typename T, bool kWide>
void walk_all(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes* hits,
              Found& found) {
  Beam<T, kWide> beam(field, rays, lanes);
  beam.run();
  beam.end(hits, found);
}

void walk_beam_here(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes* hits,
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

HWY_EXPORT(walk_beam_here);

void walk_beam(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes* hits,
               Found& found) {
  HWY_DYNAMIC_DISPATCH(walk_beam_here)(field, rays, lanes, hits, found);
}

}  // namespace isolux::lanes
#endif
