#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "isolux/base/ray.h"

namespace isolux {

/// A block of grid cells: `first` to `last`, both included, along each axis.
struct CellBlock {
  std::array<int, 3> first;
  std::array<int, 3> last;
};

/// The cells of a block that a ray passes through, in order. After Amanatides and Woo 1987, "A fast
/// voxel traversal algorithm for ray tracing", but the parameter of each wall is computed from the
/// wall's number and never added up, so that all walks over the same grid agree on it.
class GridWalk {
 public:
  /// @param ray        in index space.
  /// @param cell_size  edge of a grid cell in index units; cell c spans [c, c + 1] * cell_size.
  /// @param t_begin, t_end  the piece of the ray inside the block; t_begin <= t_end.
  GridWalk(const Ray& ray, int cell_size, const CellBlock& block, double t_begin, double t_end)
      : ray_(ray), size_(cell_size), block_(block), t_enter_(t_begin), t_end_(t_end) {
    const Vec3 start = ray.at(t_begin);
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const double cell = std::floor(start[axis] / size_);
      cell_[a] = cell < block.first[a]  ? block.first[a]
                 : cell > block.last[a] ? block.last[a]
                                        : static_cast<int>(cell);
      update_wall(axis);
    }
    choose_exit();
  }

  const std::array<int, 3>& cell() const { return cell_; }
  double t_enter() const { return t_enter_; }
  double t_exit() const { return t_exit_; }

  /// Steps to the next cell; false where the ray leaves the block.
  bool next() {
    if (t_exit_ >= t_end_) return false;
    const auto a = static_cast<std::size_t>(exit_axis_);
    cell_[a] += ray_.direction[exit_axis_] > 0 ? 1 : -1;
    if (cell_[a] < block_.first[a] || cell_[a] > block_.last[a]) return false;
    t_enter_ = t_exit_;
    update_wall(exit_axis_);
    choose_exit();
    return true;
  }

 private:
  void update_wall(int axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double d = ray_.direction[axis];
    const double wall = static_cast<double>(cell_[a] + (d > 0 ? 1 : 0)) * size_;
    t_wall_[a] = d == 0 ? std::numeric_limits<double>::infinity() : (wall - ray_.origin[axis]) / d;
  }

  void choose_exit() {
    exit_axis_ = t_wall_[0] <= t_wall_[1] ? (t_wall_[0] <= t_wall_[2] ? 0 : 2)
                                          : (t_wall_[1] <= t_wall_[2] ? 1 : 2);
    t_exit_ = std::fmin(t_wall_[static_cast<std::size_t>(exit_axis_)], t_end_);
    t_exit_ = std::fmax(t_exit_, t_enter_);  // a wall that rounding put behind us
  }

  const Ray& ray_;
  double size_;
  const CellBlock& block_;
  std::array<int, 3> cell_{};
  std::array<double, 3> t_wall_{};
  double t_enter_;
  double t_exit_ = 0;
  double t_end_;
  int exit_axis_ = 0;
};

}  // namespace isolux
