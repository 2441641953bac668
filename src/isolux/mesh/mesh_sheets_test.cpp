#include "isolux/mesh/mesh_sheets.h"

#include <gtest/gtest.h>

namespace isolux {
namespace {

TEST(MeshSheets, triangles_that_share_a_place_are_of_one_sheet) {
  // Two triangles side by side, with vertices of their own, and two that share an edge above them.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0},
                    {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
  mesh.triangles = {{0, 1, 2}, {6, 7, 8}, {3, 5, 4}, {7, 9, 8}};
  EXPECT_EQ(sheets_of(mesh), (std::vector<std::uint32_t>{0, 1, 0, 1}));
}

}  // namespace
}  // namespace isolux
