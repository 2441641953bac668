#include "isolux/mesh/simplify_mesh.h"

#include <meshoptimizer.h>

#include <limits>

#include "isolux/mesh/weld.h"

namespace isolux {
namespace {

// Appends a part's simplified triangles, with the vertex numbers of `mesh`.
void simplify_part(const Mesh& mesh, const MeshPart& part, double share, Mesh& result) {
  const std::size_t indices = std::size_t{3} * part.triangle_count;
  const std::uint32_t* from = mesh.triangles[part.first_triangle].data();
  std::vector<std::uint32_t> to(indices);
  const auto wanted =
      3 * static_cast<std::size_t>(share * static_cast<double>(part.triangle_count) + 0.5);
  constexpr float kAnyError = std::numeric_limits<float>::max();
  to.resize(meshopt_simplify(to.data(), from, indices, &mesh.positions[0].x, mesh.positions.size(),
                             sizeof(Vec3f), wanted, kAnyError));
  if (to.empty()) return;
  result.parts.push_back({static_cast<std::uint32_t>(result.triangles.size()),
                          static_cast<std::uint32_t>(to.size() / 3), part.material});
  for (std::size_t n = 0; n < to.size(); n += 3) {
    result.triangles.push_back({to[n], to[n + 1], to[n + 2]});
  }
}

}  // namespace

Mesh simplified(const Mesh& mesh, double share) {
  Mesh result = mesh;
  result.triangles.clear();
  result.parts.clear();
  for (const MeshPart& part : mesh.parts) simplify_part(mesh, part, share, result);
  drop_unused_vertices(result);
  return result;
}

}  // namespace isolux
