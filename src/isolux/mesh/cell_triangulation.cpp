#include "isolux/mesh/cell_triangulation.h"

#include <limits>
#include <optional>

namespace isolux {
namespace {

constexpr int kFaces = 6;
constexpr int kEdges = 12;

// The corners of a face, counter-clockwise as seen from outside the cell. Faces are numbered by
// 2 axis + side.
std::array<int, 4> face_corners(int face) {
  const int axis = face / 2, side = face % 2;
  const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = side << axis;
  if (side == 1) return {base, base + u, base + u + v, base + v};
  return {base, base + v, base + u + v, base + u};
}

int edge_between(int a, int b) {
  for (int edge = 0; edge < kEdges; ++edge) {
    const CellEdge& e = kCellEdges[static_cast<std::size_t>(edge)];
    if (e.corner == (a & b) && (e.corner | 1 << e.axis) == (a | b)) return edge;
  }
  return -1;
}

// Bit n: the edge lies in face n.
unsigned faces_of_edge(int edge) {
  unsigned faces = 0;
  for (int face = 0; face < kFaces; ++face) {
    const std::array<int, 4> c = face_corners(face);
    for (std::size_t n = 0; n < 4; ++n) {
      if (edge_between(c[n], c[(n + 1) % 4]) == edge) faces |= 1u << face;
    }
  }
  return faces;
}

bool is_inside(unsigned inside, int corner) { return inside >> corner & 1; }

bool is_ambiguous_face(unsigned inside, int face) {
  const std::array<int, 4> c = face_corners(face);
  return is_inside(inside, c[0]) == is_inside(inside, c[2]) &&
         is_inside(inside, c[1]) == is_inside(inside, c[3]) &&
         is_inside(inside, c[0]) != is_inside(inside, c[1]);
}

using Loop = std::vector<int>;  // edges, in the direction in which the surface bounds

// Walking round each face, every crossed edge is entered on one of its two faces and left on the
// other; so pairs "entered to left" close to loops. Where inside corners are joined across a face
// the pair cuts off a corner outside, else one inside.
std::vector<Loop> loops_of(unsigned inside, unsigned joined_faces) {
  std::array<int, kEdges> next;
  next.fill(-1);
  for (int face = 0; face < kFaces; ++face) {
    const std::array<int, 4> c = face_corners(face);
    if (is_ambiguous_face(inside, face)) {
      const bool joined = joined_faces >> face & 1;
      for (std::size_t n = 0; n < 4; ++n) {
        if (is_inside(inside, c[n]) == joined) continue;
        const int before = edge_between(c[(n + 3) % 4], c[n]);
        const int after = edge_between(c[n], c[(n + 1) % 4]);
        next[static_cast<std::size_t>(joined ? after : before)] = joined ? before : after;
      }
      continue;
    }
    int entered = -1, left = -1;
    for (std::size_t n = 0; n < 4; ++n) {
      const int a = c[n], b = c[(n + 1) % 4];
      if (!is_inside(inside, a) && is_inside(inside, b)) entered = edge_between(a, b);
      if (is_inside(inside, a) && !is_inside(inside, b)) left = edge_between(a, b);
    }
    if (entered >= 0) next[static_cast<std::size_t>(entered)] = left;
  }
  std::vector<Loop> loops;
  for (int start = 0; start < kEdges; ++start) {
    Loop loop;
    for (int edge = start; next[static_cast<std::size_t>(edge)] >= 0;) {
      loop.push_back(edge);
      const int following = next[static_cast<std::size_t>(edge)];
      next[static_cast<std::size_t>(edge)] = -1;
      edge = following;
    }
    if (!loop.empty()) loops.push_back(loop);
  }
  return loops;
}

Vec3 middle_of(int edge) {
  const CellEdge& e = kCellEdges[static_cast<std::size_t>(edge)];
  Vec3 middle{static_cast<double>(e.corner & 1), static_cast<double>(e.corner >> 1 & 1),
              static_cast<double>(e.corner >> 2)};
  middle[e.axis] = 0.5;
  return middle;
}

using Triangles = std::vector<std::array<int, 3>>;

// The triangulation of a loop with the shortest diagonals, none of them in a face: cost[i][j] is
// that of the part from i to j, on one side of the diagonal (i, j). Nothing where there is none.
class LoopTriangulator {
 public:
  explicit LoopTriangulator(const Loop& loop) : loop_(loop) {
    const std::size_t n = loop_.size();
    for (std::size_t length = 2; length < n; ++length) {
      for (std::size_t i = 0; i + length < n; ++i) solve(i, i + length);
    }
  }

  std::optional<Triangles> triangles() const {
    if (cost_[0][loop_.size() - 1] == kForbidden) return std::nullopt;
    Triangles triangles;
    collect(0, loop_.size() - 1, triangles);
    return triangles;
  }

 private:
  static constexpr double kForbidden = std::numeric_limits<double>::infinity();

  double diagonal_cost(std::size_t i, std::size_t j) const {
    const bool is_side = j == i + 1 || (i == 0 && j + 1 == loop_.size());
    if (is_side) return 0;
    if (faces_of_edge(loop_[i]) & faces_of_edge(loop_[j])) return kForbidden;
    const Vec3 d = middle_of(loop_[i]) - middle_of(loop_[j]);
    return dot(d, d);
  }

  void solve(std::size_t i, std::size_t j) {
    cost_[i][j] = kForbidden;
    for (std::size_t k = i + 1; k < j; ++k) {
      const double cost = cost_[i][k] + cost_[k][j] + diagonal_cost(i, j);
      if (cost >= cost_[i][j]) continue;
      cost_[i][j] = cost;
      apex_[i][j] = k;
    }
  }

  void collect(std::size_t i, std::size_t j, Triangles& triangles) const {
    if (j == i + 1) return;
    const std::size_t k = apex_[i][j];
    triangles.push_back({loop_[i], loop_[k], loop_[j]});
    collect(i, k, triangles);
    collect(k, j, triangles);
  }

  const Loop& loop_;
  std::array<std::array<double, kEdges>, kEdges> cost_{};
  std::array<std::array<std::size_t, kEdges>, kEdges> apex_{};
};

Triangles fan_about(int inner_vertex, const Loop& loop) {
  Triangles triangles;
  for (std::size_t n = 0; n < loop.size(); ++n) {
    triangles.push_back({loop[n], loop[(n + 1) % loop.size()], inner_vertex});
  }
  return triangles;
}

CellTriangulation triangulate(unsigned inside, unsigned joined_faces) {
  CellTriangulation result;
  for (const Loop& loop : loops_of(inside, joined_faces)) {
    std::optional<Triangles> triangles = LoopTriangulator(loop).triangles();
    if (!triangles)
      triangles = fan_about(CellTriangulation::kFirstInner + result.inner_count++, loop);
    for (const auto& t : *triangles) {
      result.triangles[result.triangle_count++] = {static_cast<std::uint8_t>(t[0]),
                                                   static_cast<std::uint8_t>(t[1]),
                                                   static_cast<std::uint8_t>(t[2])};
    }
  }
  return result;
}

// Whether the inside corners of an ambiguous face are joined: whether the bilinear interpolant is
// inside at its saddle, (ad - bc) / (a + d - b - c) with a, d inside. The products do not depend on
// which neighbour asks.
bool are_joined(int face, unsigned inside, const CellCorners& corners) {
  const std::array<int, 4> c = face_corners(face);
  const auto value = [&](std::size_t n) { return corners[static_cast<std::size_t>(c[n])]; };
  const double even = value(0) * value(2), odd = value(1) * value(3);
  return is_inside(inside, c[0]) ? even >= odd : odd >= even;
}

}  // namespace

CellTriangulations::CellTriangulations() {
  for (unsigned inside = 0; inside < patterns_.size(); ++inside) {
    Pattern& pattern = patterns_[inside];
    pattern.first = static_cast<std::uint32_t>(table_.size());
    for (int edge = 0; edge < kEdges; ++edge) {
      const CellEdge& e = kCellEdges[static_cast<std::size_t>(edge)];
      if (is_inside(inside, e.corner) != is_inside(inside, e.corner | 1 << e.axis)) {
        pattern.edges = static_cast<std::uint16_t>(pattern.edges | 1u << edge);
      }
    }
    std::vector<int> ambiguous;
    for (int face = 0; face < kFaces; ++face) {
      if (is_ambiguous_face(inside, face)) ambiguous.push_back(face);
    }
    for (unsigned way = 0; way < 1u << ambiguous.size(); ++way) {
      unsigned joined = 0;
      for (std::size_t n = 0; n < ambiguous.size(); ++n) joined |= (way >> n & 1) << ambiguous[n];
      table_.push_back(triangulate(inside, joined));
    }
    for (const int face : ambiguous) {
      pattern.faces = static_cast<std::uint8_t>(pattern.faces | 1u << face);
    }
  }
}

const CellTriangulations& CellTriangulations::instance() {
  static const CellTriangulations triangulations;
  return triangulations;
}

const CellTriangulation& CellTriangulations::of(unsigned inside, const CellCorners& corners) const {
  const Pattern& pattern = patterns_[inside];
  unsigned way = 0, digit = 1;
  for (int face = 0; face < kFaces; ++face) {
    if (!(pattern.faces >> face & 1)) continue;
    if (are_joined(face, inside, corners)) way |= digit;
    digit <<= 1;
  }
  return table_[pattern.first + way];
}

}  // namespace isolux
