#include "isolux/mesh/simplify_mesh.h"

#include <meshoptimizer.h>

#include <limits>

namespace isolux {
namespace {

constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

template <typename T>
std::vector<T> picked(const std::vector<T>& all, const std::vector<std::uint32_t>& places) {
  std::vector<T> some;
  if (all.empty()) return some;
  some.reserve(places.size());
  for (const std::uint32_t place : places) some.push_back(all[place]);
  return some;
}

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
  Mesh result;
  result.materials = mesh.materials;
  for (const MeshPart& part : mesh.parts) simplify_part(mesh, part, share, result);
  std::vector<std::uint32_t> new_place(mesh.positions.size(), kUnused), kept;
  for (Mesh::Triangle& triangle : result.triangles) {
    for (std::uint32_t& vertex : triangle) {
      if (new_place[vertex] == kUnused) {
        new_place[vertex] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(vertex);
      }
      vertex = new_place[vertex];
    }
  }
  result.positions = picked(mesh.positions, kept);
  result.normals = picked(mesh.normals, kept);
  result.texture_points = picked(mesh.texture_points, kept);
  result.colors = picked(mesh.colors, kept);
  return result;
}

}  // namespace isolux
