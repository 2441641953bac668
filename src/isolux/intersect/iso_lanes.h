#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "isolux/intersect/iso_surface.h"
#include "isolux/intersect/skip_grid.h"

namespace isolux {

namespace lanes {
struct Field;
struct Found;
}  // namespace lanes

/// Rays side by side, in the index space of a volume. What one lane holds has no influence on the
/// answer of another.
struct RayLanes {
  static constexpr int kCount = 32;

  alignas(64) double origin[3][kCount];
  alignas(64) double direction[3][kCount];  ///< of any length but zero; t counts in it
  /// The piece of the ray that is looked at, begin < t < end, with 0 <= begin <= end; end may be
  /// infinite. Both count as the doubles that they are.
  alignas(64) float begin[kCount];
  alignas(64) float end[kCount];
  /// Neighbours, such as the rays of 4 x 4 pixels, run side by side. They are quicker when that is
  /// told, and right in any case; the last bits of t may be others.
  bool is_beam = false;
};

/// Where rays meet an isosurface first.
struct HitLanes {
  std::uint32_t hit = 0;     ///< bit n: lane n; the rest of a lane that has no hit is not defined
  std::uint32_t turned = 0;  ///< lanes whose normal was turned round, to where the ray came from
  alignas(64) double t[RayLanes::kCount];
  /// The contract's normal, unit, world space, on the side that the ray came from; zero where it
  /// vanishes.
  alignas(64) float normal[3][RayLanes::kCount];
};

/// An isosurface for many rays at once, on the widest vectors that the machine has. Beside
/// IsoSurface, its plain oracle, it meets the same surface by the same definition:
///
/// A ray leaps over the blocks of a SkipGrid and steps through the cells that it marks. In such a
/// cell the field along the ray is a cubic, whose Bernstein coefficients tell most misses; else the
/// derivative's roots part it into monotone pieces, and the first that changes sign is bracketed
/// and refined by guarded Newton steps (after Yuksel 2022). The sign of the field goes with the ray
/// from cell to cell, so no crossing is lost between two cells.
///
/// The walk, the cubic and the normal are in floats, but relative to the cell: the position in the
/// cell is computed in doubles from the ray. Where a float's rounding could change whether a ray
/// hits (a graze within kDoubt of the field's spread), the oracle decides. So lanes and oracle
/// agree on what is hit, and at a hit |f - iso| <= kDoubt * the greatest |voxel - iso|.
class IsoLanes {
 public:
  static constexpr double kDoubt = 2e-6;

  /// Packets whose rays go in one stream, where there are many: enough for lanes to be seldom idle,
  /// and few enough to stay in a core's cache.
  static constexpr std::size_t kPacketsAtOnce = 8;

  /// How many bytes of voxels the vectors' gathers reach; beyond, voxels are read one by one.
  static constexpr std::size_t kReach = std::size_t{1} << 31;

  IsoLanes(IsoSurface surface, const BrickGrid& bricks, std::size_t reach = kReach);

  /// The first root of each lane whose bit is in `lanes`.
  void first_hits(const RayLanes& rays, std::uint32_t lanes, HitLanes& hits) const;

  /// The same for many packets, each lane for itself: quicker than one after the other, and the
  /// same to the bit but for beams, which are taken apart. Of as many `lanes` and `hits` as there
  /// are `rays`.
  void first_hits(std::span<const RayLanes> rays, std::span<const std::uint32_t> lanes,
                  std::span<HitLanes> hits) const;

  /// Whether there is a root at all, by the same arithmetic: a bit for each of `lanes` that
  /// `first_hits` would find a hit for.
  std::uint32_t occluded(const RayLanes& rays, std::uint32_t lanes) const;
  /// The same for many packets: takes from `lanes` those that have none.
  void occluded(std::span<const RayLanes> rays, std::span<std::uint32_t> lanes) const;

  const IsoSurface& surface() const { return surface_; }
  const SkipGrid& skip() const { return skip_; }

 private:
  lanes::Field field() const;
  void walk_all(std::span<const RayLanes> rays, std::span<const std::uint32_t> lanes,
                HitLanes* hits, std::span<lanes::Found> found) const;
  void complete(const RayLanes& rays, const lanes::Found& found, HitLanes& hits) const;
  std::uint32_t completed(const RayLanes& rays, const lanes::Found& found) const;
  std::optional<IsoHit> hit_of_oracle(const RayLanes& rays, std::size_t n) const;

  IsoSurface surface_;
  SkipGrid skip_;
  std::size_t reach_;
  double greatest_ = 0;  ///< the greatest |voxel - iso| of finite voxels
};

}  // namespace isolux
