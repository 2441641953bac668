#include "isolux/mesh/simplify_mesh.h"

#include <gtest/gtest.h>

#include "isolux/mesh/extract_isosurface.h"
#include "isolux/mesh/mesh_topology.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

TEST(SimplifyMesh, a_tenth_of_a_sphere_is_still_a_watertight_sphere_with_its_normals) {
  const Mesh whole = extract_isosurface(sphere_phantom(), 0.501);
  const Mesh tenth = simplified(whole, 0.1);
  const MeshTopology topology = topology_of(tenth);
  EXPECT_NEAR(static_cast<double>(tenth.triangles.size()),
              0.1 * static_cast<double>(whole.triangles.size()), 2);
  EXPECT_TRUE(topology.is_watertight());
  EXPECT_EQ(topology.euler_characteristic(), 2);
  EXPECT_EQ(topology.vertices, tenth.positions.size());
  ASSERT_EQ(tenth.normals.size(), tenth.positions.size());
  for (std::size_t v = 0; v < tenth.positions.size(); ++v) {
    EXPECT_GT(dot(as_double(tenth.normals[v]), normalize(as_double(tenth.positions[v]))), 0.999);
  }
}

}  // namespace
}  // namespace isolux
