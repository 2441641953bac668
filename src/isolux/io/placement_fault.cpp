#include "isolux/io/placement_fault.h"

#include <cmath>

namespace isolux {

std::string placement_fault(const Affine& world_from_index) {
  const Vec3* column = world_from_index.linear.column;
  if (!is_finite(column[0]) || !is_finite(column[1]) || !is_finite(column[2]) ||
      !is_finite(world_from_index.offset)) {
    return "holds numbers that are not finite";
  }
  const double lengths = length(column[0]) * length(column[1]) * length(column[2]);
  if (lengths == 0) return "gives an axis no length";
  constexpr double kFlat = 1e-9;
  if (!(std::fabs(determinant(world_from_index.linear)) > kFlat * lengths)) {
    return "is singular: its axes do not span space";
  }
  return {};
}

}  // namespace isolux
