#include "isolux/mesh/weld.h"

#include <bit>
#include <cstring>
#include <limits>

namespace isolux {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// All that vertex v carries, one float after the other.
using VertexData = std::array<std::uint32_t, 11>;

VertexData data_of(const Mesh& mesh, std::uint32_t v) {
  VertexData data{};
  std::size_t at = 0;
  const auto add = [&](std::initializer_list<float> numbers) {
    for (const float number : numbers) data[at++] = std::bit_cast<std::uint32_t>(number + 0.0f);
  };  // adding zero makes -0 the same as 0
  const auto add_vector = [&](const Vec3f& a) { add({a.x, a.y, a.z}); };
  add_vector(mesh.positions[v]);
  if (!mesh.normals.empty()) add_vector(mesh.normals[v]);
  if (!mesh.colors.empty()) add_vector(mesh.colors[v]);
  if (!mesh.texture_points.empty()) add({mesh.texture_points[v].u, mesh.texture_points[v].v});
  return data;
}

std::size_t hash_of(const VertexData& data) {
  std::uint64_t hash = 0;
  for (const std::uint32_t word : data) {
    hash = (hash ^ word) * 0x9e3779b97f4a7c15;
    hash ^= hash >> 29;
  }
  return hash;
}

// Finds equal vertices by an open table of vertex numbers.
class VertexTable {
 public:
  explicit VertexTable(const Mesh& mesh)
      : mesh_(mesh), slots_(std::bit_ceil(2 * mesh.positions.size() + 1), kNone) {}

  /// The first vertex seen that equals v: v itself, if it is new.
  std::uint32_t first_equal(std::uint32_t v) {
    const VertexData data = data_of(mesh_, v);
    for (std::size_t slot = hash_of(data);; ++slot) {
      std::uint32_t& held = slots_[slot & (slots_.size() - 1)];
      if (held == kNone) held = v;
      if (held == v || data_of(mesh_, held) == data) return held;
    }
  }

 private:
  const Mesh& mesh_;
  std::vector<std::uint32_t> slots_;
};

template <typename T>
void keep(std::vector<T>& values, const std::vector<std::uint32_t>& kept) {
  if (values.empty()) return;
  std::vector<T> some;
  some.reserve(kept.size());
  for (const std::uint32_t v : kept) some.push_back(values[v]);
  values = std::move(some);
}

}  // namespace

void drop_unused_vertices(Mesh& mesh) {
  std::vector<std::uint32_t> place(mesh.positions.size(), kNone), kept;
  for (Mesh::Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& vertex : triangle) {
      if (place[vertex] == kNone) {
        place[vertex] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(vertex);
      }
      vertex = place[vertex];
    }
  }
  keep(mesh.positions, kept);
  keep(mesh.normals, kept);
  keep(mesh.colors, kept);
  keep(mesh.texture_points, kept);
}

void weld(Mesh& mesh) {
  VertexTable table(mesh);
  for (Mesh::Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& vertex : triangle) vertex = table.first_equal(vertex);
  }
  drop_unused_vertices(mesh);
}

Mesh welded_by_position(const Mesh& mesh) {
  Mesh bare;
  bare.positions = mesh.positions;
  bare.triangles = mesh.triangles;
  weld(bare);
  return bare;
}

}  // namespace isolux
