#include "isolux/intersect/mesh_distance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

// Of the vertices together, since that of a thin triangle is all rounding; else its own.
Vec3 normal_of(const Mesh& mesh, const Mesh::Triangle& t) {
  if (!mesh.normals.empty()) {
    return as_double(mesh.normals[t[0]]) + as_double(mesh.normals[t[1]]) +
           as_double(mesh.normals[t[2]]);
  }
  const auto [a, b, c] = corners(mesh, t);
  return cross(b - a, c - a);
}

double distance_of(const Mesh& mesh, const Mesh::Triangle& triangle, const IsoSurface& surface) {
  const auto [a, b, c] = corners(mesh, triangle);
  const Vec3 centroid = (a + b + c) / 3;
  double nearest = std::min({length(a - centroid), length(b - centroid), length(c - centroid)});
  const Vec3 normal = normal_of(mesh, triangle);
  if (normal == Vec3{}) return nearest;
  for (const Vec3& direction : {normalize(normal), -normalize(normal)}) {
    // From a hair's breadth behind, so that a root at the centroid itself counts.
    constexpr double kBack = 1e-6;
    const auto hit = surface.first_hit({centroid - kBack * direction, direction}, nearest + kBack);
    if (hit) nearest = std::fabs(hit->t - kBack);
  }
  return nearest;
}

}  // namespace

MeshDistance distance_between(const Mesh& mesh, const IsoSurface& surface) {
  std::vector<double> distances(mesh.triangles.size());
  parallel_for(distances.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      distances[n] = distance_of(mesh, mesh.triangles[n], surface);
    }
  });
  MeshDistance result;
  for (const double distance : distances) {
    result.mean_mm += distance / static_cast<double>(distances.size());
    result.greatest_mm = std::max(result.greatest_mm, distance);
  }
  return result;
}

}  // namespace isolux
