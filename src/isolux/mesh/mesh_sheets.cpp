#include "isolux/mesh/mesh_sheets.h"

#include <numeric>

#include "isolux/mesh/weld.h"

namespace isolux {

std::vector<std::uint32_t> sheets_of(const Mesh& mesh) {
  const Mesh welded = welded_by_position(mesh);
  // Each vertex points to another of its sheet, or to itself.
  std::vector<std::uint32_t> next(welded.positions.size());
  std::iota(next.begin(), next.end(), 0u);
  const auto last = [&](std::uint32_t vertex) {
    while (next[vertex] != vertex) {
      next[vertex] = next[next[vertex]];
      vertex = next[vertex];
    }
    return vertex;
  };
  for (const auto& [a, b, c] : welded.triangles) {
    next[last(b)] = last(a);
    next[last(c)] = last(a);
  }
  constexpr std::uint32_t kNone = ~0u;
  std::vector<std::uint32_t> number(next.size(), kNone), sheets;
  std::uint32_t count = 0;
  for (const auto& [a, b, c] : welded.triangles) {
    std::uint32_t& sheet = number[last(a)];
    if (sheet == kNone) sheet = count++;
    sheets.push_back(sheet);
  }
  return sheets;
}

}  // namespace isolux
