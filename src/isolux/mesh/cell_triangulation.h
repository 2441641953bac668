#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isolux/volume/cell.h"

namespace isolux {

/// An edge of a cell: from `corner` one step along `axis`. Corners are numbered as in CellCorners.
struct CellEdge {
  int corner;
  int axis;
};

/// The twelve edges: four along each axis, each four in the order of their corners.
inline constexpr std::array<CellEdge, 12> kCellEdges = {{{0, 0},
                                                         {2, 0},
                                                         {4, 0},
                                                         {6, 0},
                                                         {0, 1},
                                                         {1, 1},
                                                         {4, 1},
                                                         {5, 1},
                                                         {0, 2},
                                                         {1, 2},
                                                         {2, 2},
                                                         {3, 2}}};

/// The triangles of an isosurface in one cell. A vertex is the number of the cell edge that it lies
/// on; 12 and more are vertices inside the cell. Seen from the side of lower values, a triangle's
/// vertices run counter-clockwise.
struct CellTriangulation {
  static constexpr std::uint8_t kFirstInner = 12;

  std::uint8_t inner_count = 0;
  std::uint8_t triangle_count = 0;
  std::array<std::array<std::uint8_t, 3>, 12> triangles{};
};

/// How an isosurface passes through a cell, for every pattern of corners inside (at or above the
/// iso value; bit n is corner n). After Lorensen and Cline 1987, "Marching cubes", but made from
/// rules in place of a printed table:
///
/// - On each face, crossed edges are joined in pairs. Where two pairings are possible (inside
///   corners face each other across a diagonal), the asymptotes of the face's bilinear interpolant
///   decide (Nielson and Hamann 1991, "The asymptotic decider"). The decision depends on the face
///   alone, so neighbours agree and the surface has no holes.
/// - The pairs close to loops, and each loop becomes a disc. No triangle has a side that lies in a
///   face without being such a pair, so no edge belongs to more than two triangles. A loop for
///   which that cannot be had gets a vertex inside the cell.
///
/// What the trilinear interpolant may do beyond that, a tunnel inside one cell, is left out.
class CellTriangulations {
 public:
  static const CellTriangulations& instance();

  /// Whether `of` needs the corner values of this pattern.
  bool is_ambiguous(unsigned inside) const { return patterns_[inside].faces != 0; }
  /// Bit n: edge n is crossed.
  unsigned crossed_edges(unsigned inside) const { return patterns_[inside].edges; }
  /// @param corners  field minus iso value; only looked at where the pattern is ambiguous.
  const CellTriangulation& of(unsigned inside, const CellCorners& corners) const;
  const CellTriangulation& of_unambiguous(unsigned inside) const {
    return table_[patterns_[inside].first];
  }

 private:
  CellTriangulations();

  struct Pattern {
    std::uint32_t first = 0;  ///< its first entry in the table: one for each way to decide
    std::uint16_t edges = 0;  ///< crossed
    std::uint8_t faces = 0;   ///< ambiguous
  };
  std::array<Pattern, 256> patterns_;
  std::vector<CellTriangulation> table_;
};

}  // namespace isolux
