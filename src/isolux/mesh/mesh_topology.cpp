#include "isolux/mesh/mesh_topology.h"

#include <algorithm>
#include <span>
#include <vector>

namespace isolux {
namespace {

// A triangle's side, kept with its lower vertex: the higher one, twice, and 1 for "runs from the
// higher to the lower". Sorted, the sides of one edge lie side by side.
using Side = std::uint64_t;

void count_edges(std::span<Side> of_vertex, MeshTopology& topology) {
  std::ranges::sort(of_vertex);
  for (std::size_t begin = 0, end = 0; begin < of_vertex.size(); begin = end) {
    std::size_t downward = 0;
    while (end < of_vertex.size() && of_vertex[end] >> 1 == of_vertex[begin] >> 1) {
      downward += of_vertex[end++] & 1;
    }
    const std::size_t sides = end - begin;
    ++topology.edges;
    if (sides == 1) ++topology.border_edges;
    if (sides > 2) ++topology.crowded_edges;
    if (sides == 2 && downward != 1) ++topology.inconsistent_edges;
  }
}

bool is_collapsed(const Mesh::Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

}  // namespace

MeshTopology topology_of(const Mesh& mesh) {
  MeshTopology topology;
  topology.triangles = mesh.triangles.size();
  // Where the sides of each lower vertex begin; counted first, then filled.
  std::vector<std::size_t> begin(mesh.positions.size() + 1);
  std::vector<bool> used(mesh.positions.size());
  const auto for_each_side = [&](const auto& use) {
    for (const Mesh::Triangle& t : mesh.triangles) {
      if (is_collapsed(t)) continue;
      for (std::size_t n = 0; n < 3; ++n) use(t[n], t[(n + 1) % 3]);
    }
  };
  for_each_side([&](std::uint32_t a, std::uint32_t b) {
    used[a] = true;
    ++begin[std::min(a, b) + std::size_t{1}];
  });
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<Side> sides(begin.back());
  std::vector<std::size_t> next(begin.begin(), begin.end());
  for_each_side([&](std::uint32_t a, std::uint32_t b) {
    sides[next[std::min(a, b)]++] = Side{std::max(a, b)} << 1 | (a > b);
  });
  for (std::size_t v = 0; v + 1 < begin.size(); ++v) {
    count_edges(std::span(sides).subspan(begin[v], begin[v + 1] - begin[v]), topology);
  }
  topology.vertices = static_cast<std::size_t>(std::ranges::count(used, true));
  topology.collapsed_triangles =
      static_cast<std::size_t>(std::ranges::count_if(mesh.triangles, is_collapsed));
  return topology;
}

}  // namespace isolux
