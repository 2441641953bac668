#include "isolux/mesh/cell_triangulation.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>

namespace isolux {
namespace {

// Corner values of a pattern, all of one size: on an ambiguous face that is a tie. `strong` corners
// (bits) are ten times as far from the iso value.
CellCorners values_of(unsigned inside, unsigned strong) {
  CellCorners values{};
  for (unsigned c = 0; c < 8; ++c) {
    values[c] = ((inside >> c & 1) ? 1 : -1) * ((strong >> c & 1) ? 10 : 1);
  }
  return values;
}

unsigned faces_of(int vertex) {
  if (vertex >= CellTriangulation::kFirstInner) return 0;
  const CellEdge& edge = kCellEdges[static_cast<std::size_t>(vertex)];
  unsigned faces = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis != edge.axis) faces |= 1u << (2 * axis + (edge.corner >> axis & 1));
  }
  return faces;
}

// Calls use(inside, triangulation) for every pattern and many ways to decide its ambiguous faces.
void for_each_triangulation(const auto& use) {
  const CellTriangulations& table = CellTriangulations::instance();
  for (unsigned inside = 0; inside < 256; ++inside) {
    for (unsigned strong = 0; strong < 256; ++strong) {
      if (strong > 0 && !table.is_ambiguous(inside)) break;
      use(inside, table.of(inside, values_of(inside, strong)));
    }
  }
}

TEST(CellTriangulation, every_side_within_a_cell_is_shared_by_two_triangles_and_leads_both_ways) {
  for_each_triangulation([](unsigned inside, const CellTriangulation& cell) {
    std::map<std::pair<int, int>, int> sides;
    for (int n = 0; n < cell.triangle_count; ++n) {
      const auto& t = cell.triangles[static_cast<std::size_t>(n)];
      for (std::size_t s = 0; s < 3; ++s) ++sides[{t[s], t[(s + 1) % 3]}];
    }
    for (const auto& [side, count] : sides) {
      EXPECT_EQ(count, 1) << inside;
      const bool is_shared = sides.contains({side.second, side.first});
      // A side in a face belongs to one triangle here, and to one of the neighbour's.
      const bool in_face = faces_of(side.first) & faces_of(side.second);
      EXPECT_NE(is_shared, in_face) << "pattern " << inside;
    }
  });
}

TEST(CellTriangulation, every_crossed_edge_has_a_vertex_and_no_other_edge_has) {
  for_each_triangulation([](unsigned inside, const CellTriangulation& cell) {
    unsigned used = 0;
    for (int n = 0; n < cell.triangle_count; ++n) {
      for (const int vertex : cell.triangles[static_cast<std::size_t>(n)]) used |= 1u << vertex;
    }
    EXPECT_EQ(used & 0xfff, CellTriangulations::instance().crossed_edges(inside));
    EXPECT_EQ(used >> 12, (1u << cell.inner_count) - 1);
  });
}

TEST(CellTriangulation, one_corner_inside_is_cut_off_by_a_triangle_that_faces_away_from_it) {
  const CellTriangulation& cell = CellTriangulations::instance().of_unambiguous(1);
  ASSERT_EQ(cell.triangle_count, 1);
  // The edges from corner 0 along x, y, z are 0, 4, 8: counter-clockwise seen from (1, 1, 1).
  const auto& t = cell.triangles[0];
  const std::array<std::uint8_t, 3> turned{t[1], t[2], t[0]};
  const std::array<std::uint8_t, 3> wanted{0, 4, 8};
  EXPECT_TRUE(t == wanted || turned == wanted ||
              (std::array<std::uint8_t, 3>{t[2], t[0], t[1]}) == wanted);
}

TEST(CellTriangulation, the_asymptotic_decider_joins_what_the_bilinear_interpolant_joins) {
  const CellTriangulations& table = CellTriangulations::instance();
  // Corners 0 and 3 inside, across the face z = 0. At its saddle the interpolant is
  // (ad - bc) / (a + d - b - c): 9/... > 0 joins them by a band of four triangles, 1 - 9 < 0 not.
  EXPECT_EQ(table.of(0b1001, {3, -1, -1, 3, -1, -1, -1, -1}).triangle_count, 4);
  EXPECT_EQ(table.of(0b1001, {1, -3, -3, 1, -1, -1, -1, -1}).triangle_count, 2);
}

}  // namespace
}  // namespace isolux
