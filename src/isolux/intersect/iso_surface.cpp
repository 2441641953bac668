#include "isolux/intersect/iso_surface.h"

#include <algorithm>
#include <cmath>

#include "isolux/intersect/cell_cubic.h"
#include "isolux/intersect/grid_walk.h"

namespace isolux {
namespace {

// Rounding turns a ray along a face into one that leans off it by a hair. Leaning below
// kParallel moves a ray by less than 1e-9 voxel over 10,000 voxels, so it counts as none; a ray
// that runs within kSlack voxels of the volume's border runs in it.
constexpr double kParallel = 1e-13;
constexpr double kSlack = 1e-9;

struct Interval {
  double begin;
  double end;
};

// The ray without its hair's breadth of lean.
Ray straightened(Ray ray) {
  const Vec3 d = ray.direction;
  const double largest = std::max({std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
  for (int axis = 0; axis < 3; ++axis) {
    if (std::fabs(d[axis]) < kParallel * largest) ray.direction[axis] = 0;
  }
  return ray;
}

std::optional<Interval> clip_to_box(const Ray& ray, const std::array<int, 3>& dims) {
  Interval inside{0, std::numeric_limits<double>::infinity()};
  for (int axis = 0; axis < 3; ++axis) {
    const double high = dims[static_cast<std::size_t>(axis)] - 1;
    const double o = ray.origin[axis];
    const double d = ray.direction[axis];
    if (d == 0) {
      if (o < -kSlack || o > high + kSlack) return std::nullopt;
      continue;
    }
    const double t0 = (0 - o) / d;
    const double t1 = (high - o) / d;
    inside.begin = std::max(inside.begin, std::min(t0, t1));
    inside.end = std::min(inside.end, std::max(t0, t1));
  }
  if (!(inside.begin <= inside.end)) return std::nullopt;
  return inside;
}

// The point at t in the cell's coordinates, exactly on a wall if that wall lies at this very t.
Vec3 local_point(const Ray& ray, const CellIndex& cell, double t) {
  Vec3 local;
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis];
    const double d = ray.direction[axis];
    const int low = cell[static_cast<std::size_t>(axis)];
    if (d != 0 && (low - o) / d == t) {
      local[axis] = 0;
    } else if (d != 0 && (low + 1 - o) / d == t) {
      local[axis] = 1;
    } else {
      local[axis] = std::clamp(o + d * t - low, 0.0, 1.0);
    }
  }
  return local;
}

struct CellPoint {
  CellIndex cell;
  Vec3 local;
};

// The cell that holds a point of index space.
std::optional<CellPoint> cell_at(const std::array<int, 3>& dims, Vec3 point) {
  CellPoint found;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = point[static_cast<int>(axis)], last = dims[axis] - 1;
    if (!(at >= -kSlack && at <= last + kSlack)) return std::nullopt;
    found.cell[axis] = std::clamp(static_cast<int>(at), 0, dims[axis] - 2);
    found.local[static_cast<int>(axis)] = std::clamp(at - found.cell[axis], 0.0, 1.0);
  }
  return found;
}

// Walks the cells in order of t. No crossing is lost between two cells: they agree on the value at
// their common face to the last bit (see `interpolate`), so one of them sees the change of sign.
template <typename T>
class FirstHitSearch {
 public:
  FirstHitSearch(const VolumeView<T>& view, const BrickGrid& bricks, const Ray& index_ray,
                 double iso, double t_max)
      : view_(view), bricks_(bricks), ray_(index_ray), iso_(iso), t_max_(t_max) {}

  std::optional<IsoHit> run(const Interval& inside) {
    const CellBlock all_bricks{
        {0, 0, 0}, {bricks_.dims()[0] - 1, bricks_.dims()[1] - 1, bricks_.dims()[2] - 1}};
    GridWalk walk(ray_, BrickGrid::kCells, all_bricks, inside.begin, inside.end);
    do {
      const BrickRange& range = bricks_.at(walk.cell());
      if (range.low > iso_ || range.high < iso_) continue;
      if (const auto hit = search_brick(walk)) return hit;
    } while (walk.next() && walk.t_enter() <= t_max_);
    return std::nullopt;
  }

 private:
  std::optional<IsoHit> search_brick(const GridWalk& brick) {
    CellBlock cells{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cells.first[axis] = brick.cell()[axis] * BrickGrid::kCells;
      cells.last[axis] = std::min(cells.first[axis] + BrickGrid::kCells, view_.dims[axis] - 1) - 1;
    }
    GridWalk walk(ray_, 1, cells, brick.t_enter(), brick.t_exit());
    do {
      if (const auto hit = search_cell(walk.cell(), walk.t_enter(), walk.t_exit())) return hit;
    } while (walk.next());
    return std::nullopt;
  }

  std::optional<IsoHit> search_cell(const CellIndex& cell, double t_enter, double t_exit) {
    if (t_exit <= 0) return std::nullopt;  // the ray's own origin, which does not count
    CellCorners corners = cell_corners(view_, cell);
    double low = corners[0], high = corners[0], sum = 0;
    for (double& corner : corners) {
      low = std::min(low, corner);
      high = std::max(high, corner);
      sum += corner;
      corner -= iso_;
    }
    if (!std::isfinite(sum)) return std::nullopt;  // NaN; infinite corners interpolate to NaN
    if (low > iso_ || high < iso_) return std::nullopt;
    const CellSegment segment{local_point(ray_, cell, t_enter), local_point(ray_, cell, t_exit),
                              t_enter <= 0};
    const auto s = first_zero(corners, segment);
    if (!s) return std::nullopt;
    const Vec3 local = *s == 1 ? segment.exit : segment.entry + *s * (segment.exit - segment.entry);
    const double t = t_enter + *s * (t_exit - t_enter);
    if (t > t_max_) return std::nullopt;
    return IsoHit{t, cell, local};
  }

  const VolumeView<T>& view_;
  const BrickGrid& bricks_;
  const Ray& ray_;
  double iso_;
  double t_max_;  ///< bounds the answer, not the arithmetic: a hit is the same for every bound
};

}  // namespace

IsoSurface::IsoSurface(std::shared_ptr<const Volume> volume,
                       std::shared_ptr<const BrickGrid> bricks, double iso)
    : volume_(std::move(volume)),
      bricks_(std::move(bricks)),
      iso_(iso),
      index_from_world_(inverse(volume_->world_from_index)),
      world_from_covector_(transpose(index_from_world_.linear)) {}

std::optional<IsoHit> IsoSurface::first_hit(const Ray& world_ray, double t_max) const {
  return first_hit_in_index_space(
      {index_from_world_.point(world_ray.origin), index_from_world_.vector(world_ray.direction)},
      t_max);
}

std::optional<IsoHit> IsoSurface::first_hit_in_index_space(const Ray& index_ray,
                                                           double t_max) const {
  const Ray ray = straightened(index_ray);
  const auto inside = clip_to_box(ray, volume_->dims);
  if (!inside) return std::nullopt;
  return visit_voxels(*volume_, [&]<typename T>(const VolumeView<T>& view) {
    return FirstHitSearch<T>(view, *bricks_, ray, iso_, t_max).run(*inside);
  });
}

std::optional<Vec3> IsoSurface::normal(const IsoHit& hit) const {
  return visit_voxels(*volume_, [&](const auto& view) -> std::optional<Vec3> {
    const auto blended = blended_gradient(view, hit.cell, hit.local);
    const Vec3 gradient =
        blended ? *blended : interpolant_gradient(cell_corners(view, hit.cell), hit.local);
    const Vec3 outward = -(world_from_covector_ * gradient);
    if (!is_finite(outward) || outward == Vec3{}) return std::nullopt;
    return normalize(outward);
  });
}

std::optional<Vec3> IsoSurface::true_normal(Vec3 on_surface) const {
  const auto found = cell_at(volume_->dims, index_from_world_.point(on_surface));
  if (!found) return std::nullopt;
  const Vec3 gradient = visit_voxels(*volume_, [&](const auto& view) {
    return interpolant_gradient(cell_corners(view, found->cell), found->local);
  });
  const Vec3 outward = -(world_from_covector_ * gradient);
  if (!is_finite(outward) || outward == Vec3{}) return std::nullopt;
  return normalize(outward);
}

std::optional<double> IsoSurface::difference(Vec3 index_point) const {
  const auto found = cell_at(volume_->dims, index_point);
  if (!found) return std::nullopt;
  const double difference = visit_voxels(*volume_, [&](const auto& view) {
    CellCorners corners = cell_corners(view, found->cell);
    for (double& corner : corners) corner -= iso_;
    return interpolate(corners, found->local);
  });
  return std::isfinite(difference) ? std::optional(difference) : std::nullopt;
}

double IsoSurface::t_before(const Ray& world_ray, double t_hit) const {
  constexpr double kLeastStep = 1e-10, kFarthestStep = 1.0 / 16, kGrowth = 8;  // voxels
  const Ray ray{index_from_world_.point(world_ray.origin),
                index_from_world_.vector(world_ray.direction)};
  const double voxel = 1 / length(ray.direction);
  double farthest = std::min(kFarthestStep * voxel, t_hit / 2);
  auto there = difference(ray.at(t_hit - farthest));
  while ((!there || *there == 0) && farthest > kLeastStep * voxel) {  // outside: not so far
    farthest /= kGrowth;
    there = difference(ray.at(t_hit - farthest));
  }
  for (double step = kLeastStep * voxel; step < farthest && there; step *= kGrowth) {
    const auto here = difference(ray.at(t_hit - step));
    if (here && *here * *there > 0) return t_hit - step;
  }
  return t_hit - farthest;
}

}  // namespace isolux
