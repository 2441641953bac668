#pragma once

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "isolux/base/ray.h"
#include "isolux/volume/volume.h"

namespace isolux::test {

/// The walker's own arithmetic: on x86-64 it has 11 bits more than the renderer's.
using Real = long double;
using Real3 = std::array<Real, 3>;

/// f - iso along the part of a ray that lies in one cell: a cubic in s = (t - t_in) / (t_out -
/// t_in), held as its four Bernstein coefficients, so the curve never leaves their hull.
struct CellSpan {
  std::array<int, 3> cell;
  Real t_in;
  Real t_out;
  std::array<Real, 4> cubic;
  bool is_certain = false;     ///< rounding cannot push the ray into a cell that holds nothing
  bool is_all_at_iso = false;  ///< nor, if the cell is wholly equal to iso, into one that is not
};

/// What is known of the first meeting of a ray and the surface, as lengths in mm along the ray;
/// infinite: never. A right answer lies in [may_hit_from, must_hit_by]. The two are together where
/// the ray crosses the surface cleanly and apart where it only grazes it; a ray that may hit but
/// need not has must_hit_by infinite (a tangency counts either way).
struct FirstMeeting {
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  double may_hit_from = kNever;  ///< where |f - iso| is first within value_doubt
  /// The smallest t > 0 with f == iso, in Real arithmetic. (A ray that starts on the surface may
  /// have a second root in its first cell; that one is not looked for.)
  double first_root = kNever;
  double must_hit_by = kNever;  ///< where f has been clearly above and clearly below iso
  double position_doubt = 0;    ///< bound on the rounding of a position by doubles, voxels
  double value_doubt = 0;       ///< and of a value there
};

/// The normal of the contract, and where it came from.
struct WalkedNormal {
  enum class Source { kBlendOfDifferences, kOwnGradient, kNothing };

  Source source;
  std::optional<Vec3> unit;  ///< towards lower values, world space
  /// The gradient's length over what it was summed from: near 0 where the terms cancel and rounding
  /// decides the direction; 0 where a difference of next to no weight is not finite, so that
  /// rounding decides the source.
  double strength;
};

/// Whether a ray that runs exactly within the volume's outer face must meet what lies there. The
/// face belongs to the volume, but only on an unturned grid does rounding keep a ray in it.
enum class OuterFace { kEitherWay, kBelongs };

/// An oracle for IsoSurface, written from the contract alone and with none of its means: it looks
/// at every cell, samples each cubic instead of expanding it, and finds roots by halving. Slow; for
/// small volumes of finite or NaN values.
class BruteForceWalker {
 public:
  /// `volume` must have cells.
  BruteForceWalker(const Volume& volume, double iso, OuterFace outer_face = OuterFace::kEitherWay);

  FirstMeeting first_meeting(const Ray& world_ray) const;
  /// The parts of the ray with t >= 0 in cells without NaN, by t_in. They leave no gap between
  /// them.
  std::vector<CellSpan> spans(const Ray& world_ray) const;
  /// The trilinear interpolant at `local` in [0, 1]^3 of a cell; NaN where the cell holds nothing.
  double value(const std::array<int, 3>& cell, Vec3 local) const;
  WalkedNormal normal(const std::array<int, 3>& cell, Vec3 local) const;

  double position_doubt(const Ray& world_ray, double t) const;
  double value_doubt(double position_doubt) const;

 private:
  std::vector<CellSpan> spans_in_widened_cells(const Ray& world_ray, Real widening) const;
  double voxel(int i, int j, int k) const;
  bool holds_something(const std::array<int, 3>& cell) const;
  bool is_all_at_iso(const std::array<int, 3>& cell) const;
  template <typename Passes>
  bool all_cells_near(const Real3& index_position, Real margin, Passes&& passes) const;
  Real interpolate(const std::array<int, 3>& cell, const Real3& local) const;
  Real3 difference_at(const std::array<int, 3>& voxel) const;
  Real3 world_covector(const Real3& index_covector) const;
  Real3 index_vector(const Real3& world_vector) const;

  std::array<int, 3> dims_;
  std::vector<double> voxels_;
  double iso_;
  OuterFace outer_face_;
  Real3 offset_;
  std::array<Real3, 3> index_from_world_;  ///< rows
  Real voxels_per_mm_;                     ///< Frobenius norm of M^-1
  Real condition_;                         ///< |M| |M^-1|
  double value_range_;
  double value_magnitude_;
};

}  // namespace isolux::test
