#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "isolux/base/ray.h"
#include "isolux/volume/brick_grid.h"
#include "isolux/volume/cell.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// Where a ray meets an isosurface.
struct IsoHit {
  double t;        ///< along the world ray, mm
  CellIndex cell;  ///< the cell in which the root lies
  Vec3 local;      ///< where in the cell, in [0, 1]^3
};

/// The set where the trilinear interpolant of a volume equals `iso`, for rays in world space.
class IsoSurface {
 public:
  /// @param volume  must have cells; @param bricks  its min-max bricks. Both are kept.
  IsoSurface(std::shared_ptr<const Volume> volume, std::shared_ptr<const BrickGrid> bricks,
             double iso);

  /// The first root along the ray with 0 < t <= t_max: exact up to the rounding of doubles, pairs
  /// of crossings within a cell included. A cell with a NaN corner holds no surface.
  std::optional<IsoHit> first_hit(const Ray& world_ray,
                                  double t_max = std::numeric_limits<double>::infinity()) const;

  /// The same for a ray in index space, of any length; t counts in that length.
  std::optional<IsoHit> first_hit_in_index_space(const Ray& index_ray, double t_max) const;

  /// The unit normal along -grad f in world space (towards lower values), with grad f the trilinear
  /// blend of central differences; where that vanishes or is not finite, the interpolant's own
  /// gradient; nothing where that vanishes too.
  std::optional<Vec3> normal(const IsoHit& hit) const;

  /// The unit normal of the surface itself at a point on it (world space), towards lower values:
  /// that of the interpolant, where `normal` is smoothed over the neighbouring cells. Nothing where
  /// it vanishes, is not finite, or the point lies outside the volume.
  std::optional<Vec3> true_normal(Vec3 on_surface) const;

  /// A t shortly before `t_hit`, the ray's first hit as lanes or this class tell it: the field has
  /// the sign there that it has between the ray's origin and the surface, in doubles. So a
  /// secondary ray that starts there starts on the side that this ray came from, by no more than
  /// the error of the hit off the surface.
  double t_before(const Ray& world_ray, double t_hit) const;

  double iso() const { return iso_; }
  const Volume& volume() const { return *volume_; }
  const Affine& index_from_world() const { return index_from_world_; }
  const Mat3& world_from_covector() const { return world_from_covector_; }

 private:
  /// The interpolant minus the iso value at a point in index space; nothing outside.
  std::optional<double> difference(Vec3 index_point) const;

  std::shared_ptr<const Volume> volume_;
  std::shared_ptr<const BrickGrid> bricks_;
  double iso_;
  Affine index_from_world_;
  Mat3 world_from_covector_;  ///< M^-T: carries gradients from index space to world space
};

}  // namespace isolux
