#include <algorithm>
#include <cmath>
#include <numeric>

#include "isolux/base/parallel.h"
#include "isolux/base/sobol.h"
#include "isolux/mesh/mesh_attributes.h"
#include "isolux/mesh/mesh_box.h"
#include "isolux/render/surface_places.h"

namespace isolux {
namespace {

// Of a mesh, in faces of blocks.
constexpr double kFaces = 160000;
constexpr double kPlacesAFace = 4;
constexpr std::uint32_t kSeed = 0x7ace5;

double area_of(const Mesh& mesh, const Mesh::Triangle& triangle) {
  const auto [a, b, c] = corners(mesh, triangle);
  return length(cross(b - a, c - a)) / 2;
}

double area_of(const Mesh& mesh) {
  double sum = 0;
  for (const Mesh::Triangle& triangle : mesh.triangles) sum += area_of(mesh, triangle);
  return sum;
}

}  // namespace

Affine block_from_world(const PreparedSurface& surface, int edge) {
  const auto shrunk = [](const Affine& map, double block) {
    return Affine{diagonal({1 / block, 1 / block, 1 / block}) * map.linear, map.offset / block};
  };
  if (const IsoLanes* lanes = surface.lanes()) {
    return shrunk(lanes->surface().index_from_world(), edge);
  }
  const Mesh& mesh = *surface.mesh();
  const double area = area_of(mesh);
  if (!(area > 0)) return {};
  const double block_mm = edge * std::sqrt(area / kFaces);
  // Walls mostly lie at round coordinates, which must not lie between two blocks.
  const Vec3 low = box_of(mesh).low - block_mm * Vec3{0.37, 0.41, 0.43};
  return shrunk({{}, -low}, block_mm);
}

std::vector<SurfacePlace> places_of(const Mesh& mesh, const Affine& block_from_world) {
  const double area = area_of(mesh);
  if (!(area > 0)) return {};
  const double scale = block_from_world.linear.at(0, 0);
  const double faces = area * scale * scale;
  const auto count = static_cast<std::size_t>(kPlacesAFace * faces) + 1;
  // The triangle of each place: places lie at even steps along the triangles' areas in a row.
  std::vector<std::uint32_t> triangle_of(count);
  std::size_t done = 0;
  double sum = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    sum += area_of(mesh, mesh.triangles[t]);
    const double steps = sum / area * static_cast<double>(count) + 0.5;
    for (; done < count && static_cast<double>(done) + 1 <= steps; ++done) triangle_of[done] = t;
  }
  for (; done < count; ++done) triangle_of[done] = triangle_of[done - 1];

  std::vector<SurfacePlace> places(count);
  parallel_for(count, 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      UnitPoint p = sobol_point(static_cast<std::uint32_t>(n), kSeed);
      if (p.u + p.v > 1) p = {1 - p.u, 1 - p.v};
      const MeshPoint point{triangle_of[n], static_cast<float>(p.u), static_cast<float>(p.v)};
      const auto [a, b, c] = corners(mesh, mesh.triangles[point.triangle]);
      const double u = point.u, v = point.v;
      SurfacePlace& place = places[n];
      place.position = (1 - u - v) * a + u * b + v * c;
      place.point = point;
      place.block = block_of(block_from_world.point(place.position));
      const Vec3 normal = shading_normal(mesh, point), across = cross(b - a, c - a);
      if (normal == Vec3{} || across == Vec3{}) continue;
      place.normal = as_float(normal);
      place.true_normal =
          as_float(dot(across, normal) < 0 ? -normalize(across) : normalize(across));
    }
  });
  std::erase_if(places, [](const SurfacePlace& place) { return place.normal == Vec3f{}; });
  std::ranges::stable_sort(places, {}, &SurfacePlace::block);
  return places;
}

}  // namespace isolux
