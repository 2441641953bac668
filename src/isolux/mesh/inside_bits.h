#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "isolux/volume/volume.h"

namespace isolux {

/// One bit for each voxel: whether it is inside an isosurface, that is, at or above the iso value;
/// and from that, 64 at a time, which edges and cells of the grid the surface crosses. Rows run
/// along i; bit n of word w stands for i = 64 w + n. Words of rows that do not exist are 0.
class InsideBits {
 public:
  using Word = std::uint64_t;

  /// One pass over the voxels, on all threads.
  InsideBits(const Volume& volume, double iso);

  const std::array<int, 3>& dims() const { return dims_; }
  int words() const { return words_; }  ///< in a row

  Word inside(int j, int k, int w) const { return at(inside_, j, k, w); }
  /// The same for the voxels one step along i.
  Word inside_next(int j, int k, int w) const { return next(inside_, j, k, w); }

  /// Cells, named by their lowest voxel, that the surface passes through. A cell with a corner that
  /// is not finite holds no surface.
  Word crossed_cells(int j, int k, int w) const;
  /// Edges from a voxel one step along `axis` that the surface crosses, so far as a cell that holds
  /// a surface has them.
  Word crossed_edges(int axis, int j, int k, int w) const;

 private:
  Word at(const std::vector<Word>& bits, int j, int k, int w) const {
    return bits[(static_cast<std::size_t>(k) * static_cast<std::size_t>(dims_[1]) +
                 static_cast<std::size_t>(j)) *
                    static_cast<std::size_t>(words_) +
                static_cast<std::size_t>(w)];
  }
  Word next(const std::vector<Word>& bits, int j, int k, int w) const {
    const Word following = w + 1 < words_ ? at(bits, j, k, w + 1) << 63 : 0;
    return at(bits, j, k, w) >> 1 | following;
  }
  /// Bits of the cells in a row, whatever is in them.
  Word row_of_cells(int w) const;
  Word sound_cells(int j, int k, int w) const;
  Word edges_of_sound_cells(int axis, int j, int k, int w) const;

  std::array<int, 3> dims_;
  int words_;
  std::vector<Word> inside_;
  std::vector<Word> finite_;  ///< empty where all voxels are finite
};

}  // namespace isolux
