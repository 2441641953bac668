#pragma once

#include <optional>

#include "isolux/volume/cell.h"

namespace isolux {

/// The piece of a ray inside one cell, in the cell's own coordinates [0, 1]^3.
struct CellSegment {
  Vec3 entry;
  Vec3 exit;
  bool open_start = false;  ///< the start itself does not count (a ray's own origin)
};

/// Where along the segment (0: entry, 1: exit) the trilinear field first is zero, if it is.
///
/// Along a line the interpolant is a cubic. Its derivative's roots part it into monotone pieces;
/// the first piece that reaches zero is bracketed and refined by Newton's method guarded by
/// bisection (after Yuksel 2022, "High-performance polynomial root finding for graphics"). So a
/// pair of crossings inside the cell is found however close they are, down to rounding. The values
/// at the ends are those of `interpolate`, so that neighbouring cells agree on their common face.
///
/// @param corners  field minus iso value at the cell's corners; all finite.
std::optional<double> first_zero(const CellCorners& corners, const CellSegment& segment);

}  // namespace isolux
