#include "isolux/mesh/extract_isosurface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/parallel.h"
#include "isolux/mesh/cell_triangulation.h"
#include "isolux/mesh/inside_bits.h"
#include "isolux/volume/cell.h"

// In passes, after Schroeder, Maynard and Geveci 2015, "Flying edges": count what each row of the
// grid holds, add up, then let each row write its own part. Differs in that voxels are told apart
// by bits, 64 at a time, so that rows without a surface cost next to nothing.

namespace isolux {
namespace {

using Word = InsideBits::Word;

// How many vertices and triangles lie in rows before this one. A row's vertices are those on edges
// along i, j and k from its voxels, then those inside its cells.
struct RowStart {
  std::array<std::uint32_t, 3> edge{};
  std::uint32_t inner = 0;
  std::uint32_t triangle = 0;
};

// Without the popcnt instruction, which not every x86-64 processor has.
std::uint32_t count_bits(Word w) {
  w -= w >> 1 & 0x5555555555555555;
  w = (w & 0x3333333333333333) + (w >> 2 & 0x3333333333333333);
  w = (w + (w >> 4)) & 0x0f0f0f0f0f0f0f0f;
  return static_cast<std::uint32_t>(w * 0x0101010101010101 >> 56);
}

Word bits_below(int n) { return n >= 64 ? ~Word{0} : (Word{1} << n) - 1; }

// Calls use(i) for the bits of word w, in order.
template <typename Use>
void for_each_bit(Word bits, int w, const Use& use) {
  for (; bits != 0; bits &= bits - 1) use(64 * w + std::countr_zero(bits));
}

template <typename T>
class Extraction {
 public:
  Extraction(const Volume& volume, const VolumeView<T>& view, double iso)
      : view_(view),
        iso_(iso),
        bits_(volume, iso),
        world_from_index_(volume.world_from_index),
        world_from_covector_(transpose(inverse(volume.world_from_index.linear))),
        is_mirrored_(determinant(volume.world_from_index.linear) < 0) {}

  Mesh run() {
    count_rows();
    const RowStart total = add_up();
    mesh_.positions.resize(total.edge[0]);
    mesh_.normals.resize(total.edge[0]);
    mesh_.triangles.resize(total.triangle);
    for_each_row([&](int j, int k) {
      for (int axis = 0; axis < 3; ++axis) write_edge_vertices(axis, j, k);
      if (j + 1 < view_.dims[1] && k + 1 < view_.dims[2]) write_triangles(j, k);
    });
    mesh_.materials = {{.name = "isosurface", .material = {}, .base_color = nullptr}};
    if (total.triangle > 0) mesh_.parts = {{0, total.triangle, 0}};
    return std::move(mesh_);
  }

 private:
  std::size_t row(int j, int k) const {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(view_.dims[1]) +
           static_cast<std::size_t>(j);
  }

  template <typename Use>
  void for_each_row(const Use& use) const {
    const auto rows_in_layer = static_cast<std::size_t>(view_.dims[1]);
    parallel_for(rows_in_layer * static_cast<std::size_t>(view_.dims[2]), 32,
                 [&](std::size_t begin, std::size_t end) {
                   for (std::size_t n = begin; n < end; ++n) {
                     use(static_cast<int>(n % rows_in_layer), static_cast<int>(n / rows_in_layer));
                   }
                 });
  }

  // --- Counting ---

  void count_rows() {
    starts_.resize(row(0, view_.dims[2]));
    for_each_row([&](int j, int k) {
      RowStart& count = starts_[row(j, k)];
      const bool has_cells = j + 1 < view_.dims[1] && k + 1 < view_.dims[2];
      for (int w = 0; w < bits_.words(); ++w) {
        for (int axis = 0; axis < 3; ++axis) {
          const Word crossed = bits_.crossed_edges(axis, j, k, w);
          if (crossed) count.edge[static_cast<std::size_t>(axis)] += count_bits(crossed);
        }
        if (!has_cells) continue;
        for_each_bit(bits_.crossed_cells(j, k, w), w, [&](int i) {
          const CellTriangulation& cell = triangulation({i, j, k}, pattern(i, j, k));
          count.triangle += cell.triangle_count;
          count.inner += cell.inner_count;
        });
      }
    });
  }

  // Turns counts into starts; returns the ends, with the number of all vertices in edge[0].
  RowStart add_up() {
    constexpr std::uint64_t kMost = 0xffffffff;
    std::uint64_t vertices = 0, triangles = 0;
    for (RowStart& start : starts_) {
      const RowStart count = start;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        start.edge[axis] = static_cast<std::uint32_t>(vertices);
        vertices += count.edge[axis];
      }
      start.inner = static_cast<std::uint32_t>(vertices);
      vertices += count.inner;
      start.triangle = static_cast<std::uint32_t>(triangles);
      triangles += count.triangle;
      if (vertices > kMost || triangles > kMost) {
        throw WorkError("isosurface", "it has more than 4294967295 triangles",
                        "resample the volume to a greater spacing, or choose another iso value");
      }
    }
    check_memory(static_cast<double>(vertices) * 2 * sizeof(Vec3f) +
                     static_cast<double>(triangles) * sizeof(Mesh::Triangle),
                 "the mesh");
    RowStart total;
    total.edge[0] = static_cast<std::uint32_t>(vertices);
    total.triangle = static_cast<std::uint32_t>(triangles);
    return total;
  }

  // --- Cells ---

  unsigned pattern(int i, int j, int k) const {
    const int w = i / 64, n = i % 64;
    unsigned inside = 0;
    for (int c = 0; c < 4; ++c) {
      const int b = j + (c & 1), d = k + (c >> 1);
      inside |= static_cast<unsigned>(bits_.inside(b, d, w) >> n & 1) << (2 * c);
      inside |= static_cast<unsigned>(bits_.inside_next(b, d, w) >> n & 1) << (2 * c + 1);
    }
    return inside;
  }

  CellCorners corners_about_iso(const CellIndex& cell) const {
    CellCorners corners = cell_corners(view_, cell);
    for (double& corner : corners) corner -= iso_;
    return corners;
  }

  const CellTriangulation& triangulation(const CellIndex& cell, unsigned inside) const {
    return table_.is_ambiguous(inside) ? table_.of(inside, corners_about_iso(cell))
                                       : table_.of_unambiguous(inside);
  }

  // --- Vertices ---

  void write_vertex(std::uint32_t vertex, const CellIndex& cell, Vec3 local, Vec3 else_gradient) {
    const Vec3 index = Vec3{static_cast<double>(cell[0]), static_cast<double>(cell[1]),
                            static_cast<double>(cell[2])} +
                       local;
    const Vec3 gradient = blended_gradient(view_, cell, local).value_or(else_gradient);
    mesh_.positions[vertex] = as_float(world_from_index_.point(index));
    mesh_.normals[vertex] = as_float(normalize(-(world_from_covector_ * gradient)));
  }

  // Where on an edge with these values, field minus iso value, the linear interpolant is zero.
  static double root_between(double at_0, double at_1) { return at_0 / (at_0 - at_1); }

  void write_edge_vertices(int axis, int j, int k) {
    std::uint32_t vertex = starts_[row(j, k)].edge[static_cast<std::size_t>(axis)];
    for (int w = 0; w < bits_.words(); ++w) {
      for_each_bit(bits_.crossed_edges(axis, j, k, w), w, [&](int i) {
        const double at_0 = view_.value(i, j, k) - iso_;
        const double at_1 = view_.value(i + (axis == 0), j + (axis == 1), k + (axis == 2)) - iso_;
        // Of the cells that share the edge, the one that there is at the far border.
        CellIndex cell{i, j, k};
        Vec3 local;
        for (int other = 0; other < 3; ++other) {
          const auto a = static_cast<std::size_t>(other);
          if (cell[a] + 1 < view_.dims[a]) continue;
          --cell[a];
          local[other] = 1;
        }
        local[axis] = root_between(at_0, at_1);
        Vec3 along_edge;
        along_edge[axis] = at_1 - at_0;
        write_vertex(vertex++, cell, local, along_edge);
      });
    }
  }

  // From the middle of the loop round it (each of whose vertices two triangles have) down the
  // interpolant's slope to its zero.
  void write_inner_vertex(std::uint32_t vertex, const CellIndex& cell,
                          const CellTriangulation& triangulation, int number) {
    const CellCorners corners = corners_about_iso(cell);
    Vec3 sum;
    int count = 0;
    for (std::size_t n = 0; n < triangulation.triangle_count; ++n) {
      const auto& t = triangulation.triangles[n];
      if (t[2] != number) continue;
      const CellEdge& edge = kCellEdges[t[0]];
      Vec3 local{static_cast<double>(edge.corner & 1), static_cast<double>(edge.corner >> 1 & 1),
                 static_cast<double>(edge.corner >> 2)};
      local[edge.axis] =
          root_between(corners[static_cast<std::size_t>(edge.corner)],
                       corners[static_cast<std::size_t>(edge.corner | 1 << edge.axis)]);
      sum = sum + local;
      ++count;
    }
    Vec3 local = sum / count;
    Vec3 gradient{1, 0, 0};  // any, should it vanish from the start
    for (int step = 0; step < 10; ++step) {
      const Vec3 slope = interpolant_gradient(corners, local);
      if (!(dot(slope, slope) > 0)) break;
      gradient = slope;
      local = local - interpolate(corners, local) / dot(slope, slope) * slope;
      for (int axis = 0; axis < 3; ++axis) local[axis] = std::clamp(local[axis], 0.0, 1.0);
    }
    write_vertex(vertex, cell, local, gradient);
  }

  // --- Triangles ---

  // The crossed edges of one row along one axis in one word, and the number of the first vertex.
  struct EdgeWord {
    Word crossed = 0;
    std::uint32_t first = 0;

    std::uint32_t vertex(int n) const { return first + count_bits(crossed & bits_below(n)); }
  };

  // The rows of edges about a row of cells: by axis, then by the step along j and k.
  struct EdgeRows {
    std::array<std::array<EdgeWord, 4>, 3> words;

    const EdgeWord& of(const CellEdge& edge) const {
      return words[static_cast<std::size_t>(edge.axis)][static_cast<std::size_t>(edge.corner >> 1)];
    }
  };

  void write_triangles(int j, int k) {
    EdgeRows edges;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (int c = 0; c < 4; ++c) {
        edges.words[axis][static_cast<std::size_t>(c)].first =
            starts_[row(j + (c & 1), k + (c >> 1))].edge[axis];
      }
    }
    std::uint32_t inner = starts_[row(j, k)].inner;
    std::uint32_t triangle = starts_[row(j, k)].triangle;
    for (int w = 0; w < bits_.words(); ++w) {
      bool any = false;
      for (int axis = 0; axis < 3; ++axis) {
        for (int c = 0; c < 4; ++c) {
          if ((axis == 1 && (c & 1)) || (axis == 2 && (c & 2))) continue;
          EdgeWord& word = edges.words[static_cast<std::size_t>(axis)][static_cast<std::size_t>(c)];
          word.crossed = bits_.crossed_edges(axis, j + (c & 1), k + (c >> 1), w);
          any |= word.crossed != 0;
        }
      }
      const Word cells = bits_.crossed_cells(j, k, w);
      for_each_bit(cells, w, [&](int i) { write_cell({i, j, k}, edges, inner, triangle); });
      if (!any) continue;
      for (auto& of_axis : edges.words) {
        for (EdgeWord& word : of_axis) word.first += count_bits(word.crossed);
      }
    }
  }

  void write_cell(const CellIndex& cell, const EdgeRows& edges, std::uint32_t& inner,
                  std::uint32_t& triangle) {
    const unsigned inside = pattern(cell[0], cell[1], cell[2]);
    const CellTriangulation& triangulation = this->triangulation(cell, inside);
    std::array<std::uint32_t, 16> vertices{};
    for (unsigned crossed = table_.crossed_edges(inside); crossed != 0; crossed &= crossed - 1) {
      const auto n = static_cast<std::size_t>(std::countr_zero(crossed));
      const CellEdge& edge = kCellEdges[n];
      // An edge at the far side of the cell may be the first of the next word.
      vertices[n] = edges.of(edge).vertex(cell[0] % 64 + (edge.corner & 1));
    }
    for (int n = 0; n < triangulation.inner_count; ++n) {
      const int number = CellTriangulation::kFirstInner + n;
      write_inner_vertex(inner, cell, triangulation, number);
      vertices[static_cast<std::size_t>(number)] = inner++;
    }
    for (std::size_t n = 0; n < triangulation.triangle_count; ++n) {
      const auto& t = triangulation.triangles[n];
      mesh_.triangles[triangle++] = {vertices[t[0]], vertices[t[is_mirrored_ ? 2 : 1]],
                                     vertices[t[is_mirrored_ ? 1 : 2]]};
    }
  }

  const VolumeView<T>& view_;
  double iso_;
  InsideBits bits_;
  Affine world_from_index_;
  Mat3 world_from_covector_;
  bool is_mirrored_;
  const CellTriangulations& table_ = CellTriangulations::instance();
  std::vector<RowStart> starts_;
  Mesh mesh_;
};

}  // namespace

Mesh extract_isosurface(const Volume& volume, double iso) {
  if (!has_cells(volume)) return {};
  return visit_voxels(volume, [&]<typename T>(const VolumeView<T>& view) {
    return Extraction<T>(volume, view, iso).run();
  });
}

}  // namespace isolux
