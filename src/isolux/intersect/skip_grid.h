#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "isolux/volume/brick_grid.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// Which cells can hold the isosurface of one value, and how far it is from anywhere else: what
/// lets a ray leap over empty space. Cells are taken in blocks of 4^3; each block has one bit a
/// cell and, for each octant of directions, how far the way is free. Around the volume lies a
/// border of empty blocks, so that a ray that rounding carries out of the volume finds nothing
/// there.
class SkipGrid {
 public:
  static constexpr int kBlockCells = 4;     ///< along a block's edge
  static constexpr int kGreatestLeap = 15;  ///< what is free further on is not told
  static constexpr int kLevels = 5;         ///< of cubes

  using Block = std::array<std::int32_t, 3>;

  /// On all threads. Looks at the voxels of those bricks only whose range holds `iso`.
  SkipGrid(const Volume& volume, const BrickGrid& bricks, double iso);

  /// Blocks along i, j, k, without the border.
  const Block& dims() const { return dims_; }
  /// The cubes of `kBlockCells << level` cells along an edge that hold surface cells; the place of
  /// each is counted in cubes of that size. Level 0: the blocks.
  const std::vector<Block>& cubes(int level) const {
    return cubes_[static_cast<std::size_t>(level)];
  }
  double bytes() const;

  /// Place in `leaps` and `cells` of a block, -1 <= block <= dims along each axis.
  std::size_t index(const Block& b) const {
    return static_cast<std::size_t>(b[0] + 1) + stride_y_ * (static_cast<std::size_t>(b[1] + 1)) +
           stride_z_ * static_cast<std::size_t>(b[2] + 1);
  }
  std::size_t stride_y() const { return stride_y_; }
  std::size_t stride_z() const { return stride_z_; }
  std::size_t size() const { return leaps_.size(); }

  /// Of a block four bits for each octant, bits 4 n to 4 n + 3 for octant n: how many blocks along
  /// an edge has the largest empty cube that begins with this block and lies in that octant; 0 in a
  /// block with a surface cell. Bit a of n: towards lower indices along axis a.
  const std::uint32_t* leaps() const { return leaps_.data(); }
  /// Bit x + 4 y + 16 z of a block's word: cell (x, y, z) of the block has corners on both sides
  /// of the iso value (or at it), all finite.
  const std::uint64_t* cells() const { return cells_.get(); }

 private:
  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };

  void measure_leaps();
  void measure_leaps(unsigned down);
  void gather_cubes();

  Block dims_{};
  std::size_t stride_y_ = 0;
  std::size_t stride_z_ = 0;
  std::vector<std::uint32_t> leaps_;
  std::unique_ptr<std::uint64_t[], Free> cells_;  ///< calloc'ed: empty regions stay untouched
  std::array<std::vector<Block>, kLevels> cubes_;
};

}  // namespace isolux
