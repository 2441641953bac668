#include "closed_form/brute_force_walker.h"

#include <algorithm>
#include <cmath>

namespace isolux::test {
namespace {

using Bernstein = std::array<Real, 4>;

/// Rounding steps between a ray in world space and a value in a cell are a few dozen.
constexpr Real kRoundings = 64;
constexpr Real kUnitRoundoff = 0x1p-53L;
/// A ray this near to a cell's wall, in voxels, may count as on either side of it.
constexpr Real kLeastMargin = 1e-9L;
/// Halving stops here: beyond it a Real has no more bits of s.
constexpr int kHalvings = 62;

Real3 as_real(Vec3 v) { return {v.x, v.y, v.z}; }
Real dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Real length(const Real3& a) { return std::sqrt(dot(a, a)); }
Real3 cross(const Real3& a, const Real3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The coefficients of the cubic through four values at s = 0, 1/3, 2/3, 1.
Bernstein cubic_through(const std::array<Real, 4>& v) {
  return {v[0], (-5 * v[0] + 18 * v[1] - 9 * v[2] + 2 * v[3]) / 6,
          (2 * v[0] - 9 * v[1] + 18 * v[2] - 5 * v[3]) / 6, v[3]};
}

/// The first s in [from, from + width] where the cubic over that range is >= 0: halve, the left
/// half first, and drop every piece whose hull is below 0. A pair of roots can hide in no piece.
std::optional<Real> first_not_negative(const Bernstein& b, Real from, Real width, int depth) {
  if (b[0] >= 0) return from;
  if (std::max({b[1], b[2], b[3]}) < 0) return std::nullopt;
  if (depth == 0) return b[3] >= 0 ? std::optional(from + width) : std::nullopt;
  const Real ab = (b[0] + b[1]) / 2, bc = (b[1] + b[2]) / 2, cd = (b[2] + b[3]) / 2;
  const Real abc = (ab + bc) / 2, bcd = (bc + cd) / 2;
  const Real middle = (abc + bcd) / 2;
  if (const auto left = first_not_negative({b[0], ab, abc, middle}, from, width / 2, depth - 1)) {
    return left;
  }
  return first_not_negative({middle, bcd, cd, b[3]}, from + width / 2, width / 2, depth - 1);
}

/// The first t in a span where factor * (f - iso) + summand >= 0.
std::optional<Real> first_t(const CellSpan& span, Real factor, Real summand) {
  Bernstein b = span.cubic;
  for (Real& coefficient : b) coefficient = factor * coefficient + summand;
  const auto s = first_not_negative(b, 0, 1, kHalvings);
  return s ? std::optional(span.t_in + *s * (span.t_out - span.t_in)) : std::nullopt;
}

Real side_of_beginning(const CellSpan& span) { return span.cubic.front() < 0 ? -1 : 1; }

/// Where f has first been clearly above and clearly below iso along spans without a break.
class SignWatch {
 public:
  void forget() { *this = SignWatch{}; }
  void see(const CellSpan& span, Real value_doubt) {
    if (!above_) above_ = first_t(span, 1, -value_doubt);
    if (!below_) below_ = first_t(span, -1, -value_doubt);
    reached_ = std::max(reached_, span.t_out);
  }
  Real reached() const { return reached_; }
  std::optional<Real> both_seen_at() const {
    return above_ && below_ ? std::optional(std::max(*above_, *below_)) : std::nullopt;
  }

 private:
  std::optional<Real> above_;
  std::optional<Real> below_;
  Real reached_ = -1;
};

}  // namespace

BruteForceWalker::BruteForceWalker(const Volume& volume, double iso, OuterFace outer_face)
    : dims_(volume.dims),
      iso_(iso),
      outer_face_(outer_face),
      offset_(as_real(volume.world_from_index.offset)) {
  visit_voxels(volume, [&](const auto& view) {
    voxels_.assign(view.voxels, view.voxels + voxel_count(volume));
  });
  double low = FirstMeeting::kNever, high = -FirstMeeting::kNever;
  for (const double v : voxels_) {
    if (std::isnan(v)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  value_range_ = std::max(0.0, high - low);
  value_magnitude_ = std::fabs(iso) + (low <= high ? std::max(std::fabs(low), std::fabs(high)) : 0);

  // The rows of an inverse are the cross products of the columns over the determinant.
  std::array<Real3, 3> column;
  for (int c = 0; c < 3; ++c) column[c] = as_real(volume.world_from_index.linear.column[c]);
  const Real det = dot(column[0], cross(column[1], column[2]));
  Real squares = 0, inverse_squares = 0;
  for (int row = 0; row < 3; ++row) {
    index_from_world_[row] = cross(column[(row + 1) % 3], column[(row + 2) % 3]);
    for (Real& entry : index_from_world_[row]) entry /= det;
    squares += dot(column[row], column[row]);
    inverse_squares += dot(index_from_world_[row], index_from_world_[row]);
  }
  voxels_per_mm_ = std::sqrt(inverse_squares);
  condition_ = std::sqrt(squares) * voxels_per_mm_;
}

double BruteForceWalker::voxel(int i, int j, int k) const {
  return voxels_[static_cast<std::size_t>(i) +
                 static_cast<std::size_t>(dims_[0]) *
                     (static_cast<std::size_t>(j) +
                      static_cast<std::size_t>(dims_[1]) * static_cast<std::size_t>(k))];
}

bool BruteForceWalker::holds_something(const std::array<int, 3>& cell) const {
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    if (std::isnan(voxel(cell[0] + x, cell[1] + y, cell[2] + z))) return false;
  }
  return true;
}

bool BruteForceWalker::is_all_at_iso(const std::array<int, 3>& cell) const {
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    if (voxel(cell[0] + x, cell[1] + y, cell[2] + z) != iso_) return false;
  }
  return true;
}

/// Whether all cells within `margin` voxels of a position pass the test, so that it does not matter
/// into which of them rounding puts the ray.
template <typename Passes>
bool BruteForceWalker::all_cells_near(const Real3& index_position, Real margin,
                                      Passes&& passes) const {
  for (int corner = 0; corner < 8; ++corner) {
    std::array<int, 3> cell;
    for (int axis = 0; axis < 3; ++axis) {
      const Real shift = (corner >> axis & 1) ? margin : -margin;
      cell[axis] = static_cast<int>(std::floor(index_position[axis] + shift));
      if (outer_face_ == OuterFace::kBelongs) {
        cell[axis] = std::clamp(cell[axis], 0, dims_[axis] - 2);
      }
      if (cell[axis] < 0 || cell[axis] > dims_[axis] - 2) return false;
    }
    if (!passes(cell)) return false;
  }
  return true;
}

Real BruteForceWalker::interpolate(const std::array<int, 3>& cell, const Real3& local) const {
  Real sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    const Real weight = (x ? local[0] : 1 - local[0]) * (y ? local[1] : 1 - local[1]) *
                        (z ? local[2] : 1 - local[2]);
    sum += weight * (static_cast<Real>(voxel(cell[0] + x, cell[1] + y, cell[2] + z)) - iso_);
  }
  return sum;
}

double BruteForceWalker::value(const std::array<int, 3>& cell, Vec3 local) const {
  return static_cast<double>(interpolate(cell, as_real(local)) + iso_);
}

Real3 BruteForceWalker::index_vector(const Real3& world_vector) const {
  return {dot(index_from_world_[0], world_vector), dot(index_from_world_[1], world_vector),
          dot(index_from_world_[2], world_vector)};
}

/// M^-T times a covector of index space.
Real3 BruteForceWalker::world_covector(const Real3& index_covector) const {
  Real3 sum{};
  for (int row = 0; row < 3; ++row) {
    for (int c = 0; c < 3; ++c) sum[c] += index_covector[row] * index_from_world_[row][c];
  }
  return sum;
}

std::vector<CellSpan> BruteForceWalker::spans(const Ray& world_ray) const {
  return spans_in_widened_cells(world_ray, 0);
}

std::vector<CellSpan> BruteForceWalker::spans_in_widened_cells(const Ray& world_ray,
                                                               Real widening) const {
  Real3 from_offset = as_real(world_ray.origin);
  for (int axis = 0; axis < 3; ++axis) from_offset[axis] -= offset_[axis];
  const Real3 origin = index_vector(from_offset);
  const Real3 direction = index_vector(as_real(world_ray.direction));
  const auto at = [&](Real t) {
    return Real3{origin[0] + t * direction[0], origin[1] + t * direction[1],
                 origin[2] + t * direction[2]};
  };

  // Slab by slab, [in, out] of every layer of cells. Neighbours share the time of their common
  // plane to the last bit, so the spans of a ray leave no gap.
  std::array<std::vector<std::array<Real, 2>>, 3> slabs;
  const Real never = std::numeric_limits<Real>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    for (int n = 0; n < dims_[axis] - 1; ++n) {
      if (direction[axis] == 0) {
        const bool inside = n - widening <= origin[axis] && origin[axis] <= n + 1 + widening;
        slabs[axis].push_back(inside ? std::array{Real(0), never} : std::array{never, -never});
      } else {
        const Real near = (n - widening - origin[axis]) / direction[axis];
        const Real far = (n + 1 + widening - origin[axis]) / direction[axis];
        slabs[axis].push_back({std::min(near, far), std::max(near, far)});
      }
    }
  }

  std::vector<CellSpan> found;
  for (int k = 0; k < dims_[2] - 1; ++k) {
    for (int j = 0; j < dims_[1] - 1; ++j) {
      for (int i = 0; i < dims_[0] - 1; ++i) {
        const Real t_in = std::max({Real(0), slabs[0][i][0], slabs[1][j][0], slabs[2][k][0]});
        const Real t_out = std::min({slabs[0][i][1], slabs[1][j][1], slabs[2][k][1]});
        const std::array cell{i, j, k};
        if (!(t_in <= t_out) || !holds_something(cell)) continue;
        std::array<Real, 4> samples;
        for (int n = 0; n < 4; ++n) {
          Real3 p = at(t_in + (t_out - t_in) * n / 3);
          for (int axis = 0; axis < 3; ++axis) p[axis] -= cell[axis];
          samples[n] = interpolate(cell, p);
        }
        found.push_back({cell, t_in, t_out, cubic_through(samples)});
      }
    }
  }
  std::sort(found.begin(), found.end(), [](const CellSpan& a, const CellSpan& b) {
    return std::pair(a.t_in, a.t_out) < std::pair(b.t_in, b.t_out);
  });
  if (found.empty()) return found;
  const Real margin = std::max<Real>(
      kLeastMargin, position_doubt(world_ray, static_cast<double>(found.back().t_out)));
  for (CellSpan& span : found) {
    const Real3 middle = at((span.t_in + span.t_out) / 2);
    span.is_certain =
        all_cells_near(middle, margin, [&](const auto& cell) { return holds_something(cell); });
    span.is_all_at_iso =
        (span.t_out - span.t_in) * length(direction) > margin && is_all_at_iso(span.cell) &&
        all_cells_near(middle, margin, [&](const auto& cell) { return is_all_at_iso(cell); });
  }
  return found;
}

FirstMeeting BruteForceWalker::first_meeting(const Ray& world_ray) const {
  FirstMeeting meeting;
  const auto keep_least = [](double& kept, std::optional<Real> t) {
    if (t) kept = std::min(kept, static_cast<double>(*t));
  };
  // Rounding may put the ray into cells that it passes by a hair.
  const std::vector<CellSpan> possible = spans_in_widened_cells(world_ray, kLeastMargin);
  if (possible.empty()) return meeting;
  meeting.position_doubt = position_doubt(world_ray, static_cast<double>(possible.back().t_out));
  meeting.value_doubt = value_doubt(meeting.position_doubt);
  const Real doubt = meeting.value_doubt;
  for (const CellSpan& span : possible) {
    // Towards iso from whichever side the span begins on; one that begins within the doubt answers
    // with its own beginning.
    keep_least(meeting.may_hit_from, first_t(span, -side_of_beginning(span), doubt));
  }

  SignWatch certain;
  Real last_value = 0, last_t = -1;
  for (const CellSpan& span : spans(world_ray)) {
    const Real first_value = span.cubic.front();
    if (span.t_out > 0) {
      const auto root =
          first_value == 0 ? std::optional(span.t_in) : first_t(span, -side_of_beginning(span), 0);
      if (root && *root > 0) keep_least(meeting.first_root, root);
      // A root on a common face, which rounding may deny to both cells.
      if (span.t_in > 0 && span.t_in == last_t && first_value * last_value < 0) {
        keep_least(meeting.first_root, span.t_in);
      }
    }
    last_value = span.cubic.back();
    last_t = span.t_out;

    if (!span.is_certain || span.t_in > certain.reached()) certain.forget();
    if (!span.is_certain) continue;
    certain.see(span, doubt);
    keep_least(meeting.must_hit_by, certain.both_seen_at());
    // Met on entry; a ray that starts within it has no entry and, as roots fill it, no first root.
    if (span.is_all_at_iso) {
      const bool is_entered = span.t_in * voxels_per_mm_ > kLeastMargin;
      keep_least(meeting.must_hit_by, is_entered ? span.t_in : span.t_out);
    }
  }
  return meeting;
}

/// Rounding in M^-1 grows with the condition of M, and that of a position with the largest length
/// that enters it.
double BruteForceWalker::position_doubt(const Ray& world_ray, double t) const {
  const Real longest = length(as_real(world_ray.origin)) + length(offset_) + std::fabs(t);
  return static_cast<double>(kRoundings * kUnitRoundoff * condition_ * voxels_per_mm_ * longest);
}

/// Within a cell f changes by at most its range along each of three axes.
double BruteForceWalker::value_doubt(double position_doubt) const {
  return 3 * value_range_ * position_doubt +
         static_cast<double>(kRoundings * kUnitRoundoff) * value_magnitude_;
}

/// Half the difference of the two neighbours along each axis; at the border the whole difference
/// to the one that there is.
Real3 BruteForceWalker::difference_at(const std::array<int, 3>& at) const {
  Real3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    std::array<int, 3> low = at, high = at;
    low[axis] = std::max(0, at[axis] - 1);
    high[axis] = std::min(dims_[axis] - 1, at[axis] + 1);
    gradient[axis] = (static_cast<Real>(voxel(high[0], high[1], high[2])) -
                      static_cast<Real>(voxel(low[0], low[1], low[2]))) /
                     (high[axis] - low[axis]);
  }
  return gradient;
}

WalkedNormal BruteForceWalker::normal(const std::array<int, 3>& cell, Vec3 local) const {
  const Real3 u = as_real(local);
  Real3 blend{}, own{};
  Real largest_difference = 0, largest_step = 0;
  bool is_doubtful = false;  // a difference is not finite and hardly counts
  for (int corner = 0; corner < 8; ++corner) {
    const std::array bit{corner & 1, corner >> 1 & 1, corner >> 2};
    const std::array at{cell[0] + bit[0], cell[1] + bit[1], cell[2] + bit[2]};
    std::array<Real, 3> weight;
    for (int axis = 0; axis < 3; ++axis) weight[axis] = bit[axis] ? u[axis] : 1 - u[axis];
    const Real3 difference = difference_at(at);
    if (!std::isfinite(length(difference)) && weight[0] * weight[1] * weight[2] < kLeastMargin) {
      is_doubtful = true;
    }
    largest_difference = std::max(largest_difference, length(difference));
    for (int axis = 0; axis < 3; ++axis) {
      blend[axis] += weight[0] * weight[1] * weight[2] * difference[axis];
      // The derivative of the interpolant: blend, over the other two axes, the steps of the cell's
      // edges along this one, each taken at the edge's upper end.
      if (!bit[axis]) continue;
      std::array<int, 3> below = at;
      --below[axis];
      const Real step = static_cast<Real>(voxel(at[0], at[1], at[2])) -
                        static_cast<Real>(voxel(below[0], below[1], below[2]));
      own[axis] += weight[(axis + 1) % 3] * weight[(axis + 2) % 3] * step;
      largest_step = std::max(largest_step, std::fabs(step));
    }
  }
  const auto along = [&](WalkedNormal::Source source, const Real3& gradient, Real largest) {
    const Real3 world = world_covector(gradient);
    const Real size = length(world);
    const Vec3 unit{static_cast<double>(-world[0] / size), static_cast<double>(-world[1] / size),
                    static_cast<double>(-world[2] / size)};
    const Real strength = is_doubtful ? 0 : size / (voxels_per_mm_ * largest);
    return WalkedNormal{source, unit, static_cast<double>(strength)};
  };
  if (std::isfinite(dot(blend, blend)) && dot(blend, blend) > 0) {
    return along(WalkedNormal::Source::kBlendOfDifferences, blend, largest_difference);
  }
  if (std::isfinite(dot(own, own)) && dot(own, own) > 0) {
    return along(WalkedNormal::Source::kOwnGradient, own, largest_step);
  }
  return {WalkedNormal::Source::kNothing, std::nullopt, 0};
}

}  // namespace isolux::test
