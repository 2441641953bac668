#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "isolux/render/scene_surfaces.h"
#include "isolux/render/surface_places.h"

namespace isolux {

/// Where a sample lies: a place of a surface that stands for those near it whose normals are like
/// its own.
struct SampleSite {
  Vec3 position;      ///< mm, on the surface
  Vec3f in_blocks;    ///< the same in the space of the surface's blocks
  Vec3f normal;       ///< unit: the shading normal, on the surface's outside
  Vec3f true_normal;  ///< unit: that of the surface itself, on the same side
  std::int32_t surface;
  MeshPoint point;      ///< on a mesh
  std::uint32_t sheet;  ///< of a mesh: see SurfaceSamples::sheet
};

/// From where a point of a surface is seen, and how it so is lit.
struct SeenSide {
  bool inside = false;  ///< from the inside of the surface itself
  /// Whether the shading normal had to be turned to a side on which the surface itself does not
  /// lie: where it is smoother than the surface, some points are lit as from behind.
  bool flipped = false;
};

/// Whether a ray of that direction has met the surface from inside; `outward` is the shading normal
/// on the outside.
bool is_inside(const PreparedSurface& surface, Vec3 position, const MeshPoint& point, Vec3 outward,
               Vec3 direction);

/// Samples all over the surfaces of a scene, which stand for the light there: in each block of a
/// few cells one for each group of normals, each sheet of a mesh and each side, for surfaces are
/// lit from both sides; so a block that holds a sheet of bone has samples outside and inside of
/// either of its faces. They depend on the surfaces alone.
///
/// Samples count from 0, four to a site (see SeenSide): first the outsides of all sites, which are
/// mostly all that is ever seen, so that what is used lies together.
class SurfaceSamples {
 public:
  static constexpr std::uint32_t kNone = ~0u;

  /// @param edge  of the blocks: see block_from_world.
  SurfaceSamples(const SceneSurfaces& surfaces, int edge);

  std::size_t size() const { return 4 * sites_.size(); }
  const std::vector<SampleSite>& sites() const { return sites_; }
  const SampleSite& site(std::uint32_t sample) const { return sites_[sample % count()]; }
  std::uint32_t sample(std::uint32_t site, SeenSide side) const {
    return site + count() * ((side.inside ? 2 : 0) + (side.flipped ? 1 : 0));
  }
  SeenSide side(std::uint32_t sample) const {
    const std::uint32_t which = sample / count();
    return {(which & 2) != 0, (which & 1) != 0};
  }
  /// Unit, as it is lit.
  Vec3 normal(std::uint32_t sample) const {
    const auto [inside, flipped] = side(sample);
    return (inside == flipped ? 1.0 : -1.0) * as_double(site(sample).normal);
  }
  /// Unit, on the side that it is seen from.
  Vec3 true_normal(std::uint32_t sample) const {
    return (side(sample).inside ? -1.0 : 1.0) * as_double(site(sample).true_normal);
  }

  /// Which of a mesh's sheets a point lies on, those parts that do not hang together; 0 on an
  /// isosurface, where the volume keeps sheets apart.
  std::uint32_t sheet(std::int32_t surface, const MeshPoint& point) const {
    const auto& sheets = sheets_[static_cast<std::size_t>(surface)];
    return sheets.empty() ? 0 : sheets[point.triangle];
  }

  /// A place of a surface in the space of its blocks.
  Vec3 in_blocks(std::int32_t surface, Vec3 position) const {
    return grids_[static_cast<std::size_t>(surface)].block_from_world.point(position);
  }

  /// Within this distance of a point of a surface, what it sees changes within a block.
  double close_mm(std::int32_t surface) const {
    return grids_[static_cast<std::size_t>(surface)].close_mm;
  }
  /// The edge of a block, as if it were a cube.
  double block_mm(std::int32_t surface) const;

  /// What gives a distance from a plane when multiplied with a vector there, both in that space.
  Vec3 normal_in_blocks(std::int32_t surface, Vec3 normal) const {
    return normalize(grids_[static_cast<std::size_t>(surface)].blocks_from_covector * normal);
  }

  /// The sample that stands for a place: in its block, or in those around it, the one whose normal
  /// is most like its own and that is not far, of its own sheet if there is one. `outward` is the
  /// shading normal on the outside. kNone: there is none anywhere near.
  std::uint32_t find(std::int32_t surface, Vec3 position, const MeshPoint& point, Vec3 outward,
                     SeenSide side) const {
    return find_in_blocks(surface, in_blocks(surface, position), sheet(surface, point), outward,
                          side);
  }
  std::uint32_t find_in_blocks(std::int32_t surface, Vec3 at, std::uint32_t sheet, Vec3 outward,
                               SeenSide side) const;

  /// Calls body(number of a site) for those of a surface in blocks from `low` to `high`.
  template <typename Body>
  void each_site(std::int32_t surface, const BlockIndex& low, const BlockIndex& high,
                 const Body& body) const {
    const Grid& grid = grids_[static_cast<std::size_t>(surface)];
    for (std::int32_t z = low[2]; z <= high[2]; ++z) {
      for (std::int32_t y = low[1]; y <= high[1]; ++y) {
        for (std::int32_t row = low[0] >> kRowShift; row <= high[0] >> kRowShift; ++row) {
          const Row* blocks = grid.row({row, y, z});
          if (!blocks) continue;
          const std::int32_t first = std::max(low[0] - (row << kRowShift), 0);
          const std::int32_t last = std::min(high[0] - (row << kRowShift), kRow - 1);
          for (std::int32_t x = first; x <= last; ++x) {
            const Run& run = (*blocks)[static_cast<std::size_t>(x)];
            for (std::uint32_t n = 0; n < run.count; ++n) body(run.first + n);
          }
        }
      }
    }
  }

  double bytes() const;

 private:
  static constexpr int kRowShift = 3;
  static constexpr std::int32_t kRow = 1 << kRowShift;

  // The sites of a block.
  struct Run {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  using Row = std::array<Run, kRow>;  // eight blocks along x

  // Where the blocks of a surface are.
  class Grid {
   public:
    Affine block_from_world;
    Mat3 blocks_from_covector;
    double close_mm;

    void add(const BlockIndex& block, Run run);
    const Row* row(const BlockIndex& at) const;
    double bytes() const;

   private:
    struct Slot;

    static std::uint64_t key(const BlockIndex& at);
    Slot& slot_for(std::uint64_t wanted);
    void grow();

    struct Slot {
      std::uint64_t key = 0;  // 0: nothing is there
      std::uint32_t place = 0;
    };
    // Open addressing; a power of two.
    std::vector<Slot> slots_;
    std::vector<Row> rows_;
  };

  std::uint32_t count() const { return static_cast<std::uint32_t>(sites_.size()); }
  void add(const PreparedSurface& surface, std::int32_t number, int edge);

  std::vector<SampleSite> sites_;
  std::vector<Grid> grids_;
  std::vector<std::vector<std::uint32_t>> sheets_;  // [surface][triangle]
};

}  // namespace isolux
