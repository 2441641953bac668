#include "isolux/mesh/smooth_normals.h"

#include <span>

#include "isolux/base/exact_math.h"
#include "isolux/base/parallel.h"
#include "isolux/mesh/weld.h"

namespace isolux {
namespace {

constexpr std::size_t kGrain = 1 << 12;  // triangles
// Where more triangles meet in one place, each keeps its own normal there: a hub is flat or of no
// shape, and would take a time that grows with its square.
constexpr std::size_t kMostAtOnePlace = 1024;

// The triangles that meet in each place, in the order of their numbers.
class TrianglesAt {
 public:
  explicit TrianglesAt(const Mesh& mesh) : begin_(mesh.positions.size() + 1) {
    for (const Mesh::Triangle& triangle : mesh.triangles) {
      for (const std::uint32_t place : triangle) ++begin_[place + std::size_t{1}];
    }
    for (std::size_t n = 1; n < begin_.size(); ++n) begin_[n] += begin_[n - 1];
    triangles_.resize(begin_.back());
    std::vector<std::size_t> next(begin_.begin(), begin_.end());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (const std::uint32_t place : mesh.triangles[t]) triangles_[next[place]++] = t;
    }
  }

  std::span<const std::uint32_t> of(std::uint32_t place) const {
    return std::span(triangles_)
        .subspan(begin_[place], begin_[place + std::size_t{1}] - begin_[place]);
  }

 private:
  std::vector<std::size_t> begin_;
  std::vector<std::uint32_t> triangles_;
};

// The angle between two sides, within half a degree: that is enough for a weight, and the same on
// every machine.
double angle_between(Vec3 a, Vec3 b) {
  const double opposite = length(cross(a, b)), adjacent = length(a) * length(b) + dot(a, b);
  // atan(x) is near x / (1 + 0.28 x^2) for x in [0, 1]; of half the angle, which is at most 90.
  const auto near_atan = [](double x) { return x / (1 + 0.28 * x * x); };
  return opposite <= adjacent ? 2 * near_atan(opposite / adjacent)
                              : exact::kPi - 2 * near_atan(adjacent / opposite);
}

// What a triangle adds to the normal of its corner `place`: its own, weighted by the angle there,
// so that it does not matter how a flat side is cut into triangles (after Thuermer and Wuethrich
// 1998, "Computing vertex normals from polygonal facets").
Vec3 share_of(const Mesh& mesh, std::uint32_t triangle, std::uint32_t place, Vec3 face_normal) {
  if (face_normal == Vec3{}) return {};
  const Mesh::Triangle& t = mesh.triangles[triangle];
  std::size_t corner = 0;
  while (t[corner] != place) ++corner;
  const auto points = corners(mesh, t);
  return angle_between(points[(corner + 1) % 3] - points[corner],
                       points[(corner + 2) % 3] - points[corner]) *
         face_normal;
}

// Unit, or 0 for a triangle without area.
Vec3 face_normal(const Mesh& mesh, std::uint32_t triangle) {
  const auto [a, b, c] = corners(mesh, mesh.triangles[triangle]);
  const Vec3 normal = cross(b - a, c - a);
  return normal == Vec3{} ? normal : normalize(normal);
}

template <typename T>
std::vector<T> one_a_corner(const std::vector<T>& values, const Mesh& mesh) {
  std::vector<T> spread;
  if (values.empty()) return spread;
  spread.reserve(3 * mesh.triangles.size());
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) spread.push_back(values[vertex]);
  }
  return spread;
}

}  // namespace

Mesh with_smooth_normals(const Mesh& mesh, double crease_deg) {
  // Places, since vertices with other texture points or colours are the same surface. Welding keeps
  // the order of triangles.
  const Mesh places = welded_by_position(mesh);
  const TrianglesAt triangles_at(places);
  std::vector<Vec3> faces(places.triangles.size());
  std::vector<Vec3f> normals(3 * places.triangles.size());
  const auto for_each_triangle = [&](const auto& use) {
    parallel_for(places.triangles.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) use(static_cast<std::uint32_t>(t));
    });
  };
  for_each_triangle([&](std::uint32_t t) { faces[t] = face_normal(places, t); });
  // At 180 degrees rounding must not leave out what faces the other way.
  const double least_cos = crease_deg < 180 ? exact::cos(exact::radians(crease_deg)) : -2;
  for_each_triangle([&](std::uint32_t t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t place = places.triangles[t][corner];
      const auto around = triangles_at.of(place);
      if (around.size() > kMostAtOnePlace) continue;
      Vec3 sum;
      for (const std::uint32_t other : around) {
        if (other != t && dot(faces[other], faces[t]) < least_cos) continue;
        sum = sum + share_of(places, other, place, faces[other]);
      }
      if (sum != Vec3{}) normals[3 * std::size_t{t} + corner] = as_float(normalize(sum));
    }
  });

  Mesh smooth;
  smooth.positions = one_a_corner(mesh.positions, mesh);
  smooth.normals = std::move(normals);
  smooth.texture_points = one_a_corner(mesh.texture_points, mesh);
  smooth.colors = one_a_corner(mesh.colors, mesh);
  smooth.triangles.resize(mesh.triangles.size());
  for (std::uint32_t t = 0; t < smooth.triangles.size(); ++t) {
    smooth.triangles[t] = {3 * t, 3 * t + 1, 3 * t + 2};
  }
  smooth.materials = mesh.materials;
  smooth.parts = mesh.parts;
  weld(smooth);
  return smooth;
}

}  // namespace isolux
