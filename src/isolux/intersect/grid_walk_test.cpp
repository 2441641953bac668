#include "isolux/intersect/grid_walk.h"

#include <gtest/gtest.h>

#include <vector>

namespace isolux {
namespace {

using Cell = std::array<int, 3>;

std::vector<Cell> cells_of(const Ray& ray, int size, const CellBlock& block, double begin,
                           double end) {
  GridWalk walk(ray, size, block, begin, end);
  std::vector<Cell> cells;
  double t = begin;
  do {
    EXPECT_EQ(walk.t_enter(), t);  // no gaps
    EXPECT_GE(walk.t_exit(), walk.t_enter());
    t = walk.t_exit();
    cells.push_back(walk.cell());
  } while (walk.next());
  return cells;
}

TEST(GridWalk, visits_the_cells_of_a_line_in_order) {
  const Ray ray{{0.5, 0.375, 0.5}, {1, 0.5, 0}};
  EXPECT_EQ(cells_of(ray, 1, {{0, 0, 0}, {2, 2, 2}}, 0, 2.5),
            (std::vector<Cell>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {2, 1, 0}}));
}

TEST(GridWalk, goes_backwards_and_in_larger_cells) {
  const Ray ray{{31, 4, 4}, {-1, 0, 0}};
  EXPECT_EQ(cells_of(ray, 8, {{0, 0, 0}, {3, 0, 0}}, 0, 31),
            (std::vector<Cell>{{3, 0, 0}, {2, 0, 0}, {1, 0, 0}, {0, 0, 0}}));
}

TEST(GridWalk, a_ray_along_an_edge_or_a_diagonal_stays_in_the_block_and_reaches_its_end) {
  for (const Ray& ray : {Ray{{0, 2, 2}, {1, 0, 0}}, Ray{{0, 0, 0}, {1, 1, 1}},
                         Ray{{3, 3, 0}, {-1, -1, 1}}, Ray{{3, 3, 3}, {-1, 0, 0}}}) {
    const auto cells = cells_of(ray, 1, {{0, 0, 0}, {2, 2, 2}}, 0, 3);
    EXPECT_GE(cells.size(), 3u);
    for (const Cell& cell : cells) {
      for (const int at : cell) {
        EXPECT_GE(at, 0);
        EXPECT_LE(at, 2);
      }
    }
  }
}

}  // namespace
}  // namespace isolux
