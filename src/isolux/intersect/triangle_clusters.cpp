#include "isolux/intersect/triangle_clusters.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

constexpr std::size_t kCount = TriangleCluster::kCount;
struct PlacedTriangle {
  Vec3f middle;
  std::uint32_t triangle;
};

// Halves the triangles along the longest edge of their box, again and again, so that all clusters
// but the last of each piece are full.
void sort_by_place(std::span<PlacedTriangle> triangles) {
  if (triangles.size() <= kCount) return;
  Vec3f low = triangles[0].middle, high = low;
  for (const PlacedTriangle& one : triangles) {
    low = {std::min(low.x, one.middle.x), std::min(low.y, one.middle.y),
           std::min(low.z, one.middle.z)};
    high = {std::max(high.x, one.middle.x), std::max(high.y, one.middle.y),
            std::max(high.z, one.middle.z)};
  }
  const float extent[3] = {high.x - low.x, high.y - low.y, high.z - low.z};
  const auto axis = std::max_element(extent, extent + 3) - extent;
  constexpr float Vec3f::*kAxes[3] = {&Vec3f::x, &Vec3f::y, &Vec3f::z};
  const float Vec3f::*along = kAxes[axis];
  const std::size_t half = (triangles.size() / 2 + kCount - 1) / kCount * kCount;
  std::nth_element(triangles.begin(), triangles.begin() + static_cast<std::ptrdiff_t>(half),
                   triangles.end(), [along](const PlacedTriangle& a, const PlacedTriangle& b) {
                     return std::pair(a.middle.*along, a.triangle) <
                            std::pair(b.middle.*along, b.triangle);
                   });
  constexpr std::size_t kAtOnce = 1 << 14;
  const std::span<PlacedTriangle> halves[2] = {triangles.first(half), triangles.subspan(half)};
  if (triangles.size() < kAtOnce) {
    for (const auto& one : halves) sort_by_place(one);
    return;
  }
  parallel_for(2, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) sort_by_place(halves[n]);
  });
}

std::vector<PlacedTriangle> sorted_by_place(const Mesh& mesh) {
  std::vector<PlacedTriangle> sorted(mesh.triangles.size());
  parallel_for(sorted.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const auto [a, b, c] = corners(mesh, mesh.triangles[n]);
      sorted[n] = {as_float((a + b + c) / 3.0), static_cast<std::uint32_t>(n)};
    }
  });
  sort_by_place(sorted);
  return sorted;
}

void fill(TriangleCluster& cluster, const Mesh& mesh, const PlacedTriangle* first,
          std::size_t count) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  float low[3] = {kInfinity, kInfinity, kInfinity}, high[3] = {-kInfinity, -kInfinity, -kInfinity};
  for (std::size_t n = 0; n < kCount; ++n) {
    cluster.triangle[n] = first[std::min(n, count - 1)].triangle;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3f& corner = mesh.positions[mesh.triangles[cluster.triangle[n]][c]];
      const float at[3] = {corner.x, corner.y, corner.z};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        cluster.corner[c][axis][n] = at[axis];
        low[axis] = std::min(low[axis], at[axis]);
        high[axis] = std::max(high[axis], at[axis]);
      }
    }
  }
  cluster.low = {low[0], low[1], low[2]};
  cluster.high = {high[0], high[1], high[2]};
}

}  // namespace

std::vector<TriangleCluster> cluster_triangles(const Mesh& mesh) {
  const std::vector<PlacedTriangle> sorted = sorted_by_place(mesh);
  std::vector<TriangleCluster> clusters((sorted.size() + kCount - 1) / kCount);
  parallel_for(clusters.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const std::size_t first = kCount * n;
      fill(clusters[n], mesh, &sorted[first], std::min(kCount, sorted.size() - first));
    }
  });
  return clusters;
}

}  // namespace isolux
