#include "isolux/render/scene_surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "isolux/mesh/extract_isosurface.h"
#include "isolux/mesh/mesh_box.h"

namespace isolux {
namespace {

// Of the voxel's shortest edge, and of a mesh's extent.
constexpr double kVoxelStep = 1e-4;
constexpr double kMeshStep = 1e-8;

double longest_diagonal(const Affine& world_from_index) {
  double longest = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const Vec3 diagonal{1, corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0};
    longest = std::max(longest, length(world_from_index.vector(diagonal)));
  }
  return longest;
}

std::vector<float> longest_edges(const Mesh& mesh) {
  std::vector<float> longest(mesh.positions.size());
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    const auto points = corners(mesh, triangle);
    for (std::size_t n = 0; n < 3; ++n) {
      const std::size_t next = (n + 1) % 3;
      const auto edge = static_cast<float>(length(points[next] - points[n]));
      for (const std::size_t end : {n, next}) {
        longest[triangle[end]] = std::max(longest[triangle[end]], edge);
      }
    }
  }
  return longest;
}

void set_in_index_space(const Affine& index_from_world, const RayPacket& rays, RayLanes& lanes) {
  for (int row = 0; row < 3; ++row) {
    const double a = index_from_world.linear.at(row, 0), b = index_from_world.linear.at(row, 1),
                 c = index_from_world.linear.at(row, 2), d = index_from_world.offset[row];
    const auto& [ox, oy, oz] = rays.origin;
    const auto& [dx, dy, dz] = rays.direction;
    for (int n = 0; n < RayPacket::kCount; ++n) {
      lanes.origin[row][n] = a * ox[n] + b * oy[n] + c * oz[n] + d;
      lanes.direction[row][n] = a * dx[n] + b * dy[n] + c * dz[n];
    }
  }
  std::ranges::copy(rays.begin, lanes.begin);
  std::ranges::copy(rays.end, lanes.end);
}

// Calls body(number of the first packet, packets) for as many at a time as go together.
template <typename Body>
void in_index_space(const IsoLanes& surface, std::span<const RayPacket> rays, const Body& body) {
  std::array<RayLanes, IsoLanes::kPacketsAtOnce> lanes;
  for (std::size_t first = 0; first < rays.size(); first += lanes.size()) {
    const std::size_t count = std::min(lanes.size(), rays.size() - first);
    for (std::size_t p = 0; p < count; ++p) {
      set_in_index_space(surface.surface().index_from_world(), rays[first + p], lanes[p]);
    }
    body(first, std::span<const RayLanes>(lanes.data(), count));
  }
}

}  // namespace

PreparedSurface::PreparedSurface(std::shared_ptr<const IsoLanes> lanes) : lanes_(std::move(lanes)) {
  const Volume& volume = lanes_->surface().volume();
  const Vec3 spacing = spacing_mm(volume);
  voxel_diagonal_mm_ = longest_diagonal(volume.world_from_index);
  step_mm_ = kVoxelStep * std::min({spacing.x, spacing.y, spacing.z});
}

PreparedSurface::PreparedSurface(std::shared_ptr<const Mesh> mesh,
                                 std::shared_ptr<const MeshSurface> tree)
    : mesh_(std::move(mesh)), tree_(std::move(tree)) {
  if (!tree_) return;
  longest_edges_mm_ = std::make_shared<const std::vector<float>>(longest_edges(*mesh_));
  const MeshBox box = box_of(*mesh_);
  step_mm_ = kMeshStep * (length(box.high - box.low) + length(box.low) + length(box.high));
}

void PreparedSurface::first_hits(const RayPacket& rays, std::uint32_t lanes, std::int32_t number,
                                 PacketHits& hits) const {
  first_hits({&rays, 1}, {&lanes, 1}, number, {&hits, 1});
}

void PreparedSurface::first_hits(std::span<const RayPacket> rays,
                                 std::span<const std::uint32_t> lanes, std::int32_t number,
                                 std::span<PacketHits> hits) const {
  if (lanes_) {
    std::array<HitLanes, IsoLanes::kPacketsAtOnce> found;
    in_index_space(*lanes_, rays, [&](std::size_t first, std::span<const RayLanes> packets) {
      lanes_->first_hits(packets, lanes.subspan(first, packets.size()),
                         std::span(found).first(packets.size()));
      for (std::size_t p = 0; p < packets.size(); ++p) hits[first + p].add(found[p], number);
    });
  } else if (tree_) {
    for (std::size_t p = 0; p < rays.size(); ++p) {
      first_hits_of_mesh(rays[p], lanes[p], number, hits[p]);
    }
  }
}

void PreparedSurface::first_hits_of_mesh(const RayPacket& rays, std::uint32_t lanes,
                                         std::int32_t number, PacketHits& hits) const {
  MeshHitLanes found;
  tree_->first_hits(rays, lanes, found);
  if (found.hit == 0) return;
  MeshPointLanes points;
  find_mesh_points(*mesh_, rays, found.triangle, found.hit, points);
  hits.add(points, found.triangle, number);
}

void PreparedSurface::any_hits(std::span<const RayPacket> rays,
                               std::span<std::uint32_t> lanes) const {
  if (lanes_) {
    in_index_space(*lanes_, rays, [&](std::size_t first, std::span<const RayLanes> packets) {
      lanes_->occluded(packets, lanes.subspan(first, packets.size()));
    });
    return;
  }
  for (std::size_t p = 0; p < rays.size(); ++p) {
    lanes[p] = tree_ ? tree_->occluded(rays[p], lanes[p]) : 0;
  }
}

bool PreparedSurface::any_hit(const Ray& ray, double t_max) const {
  if (lanes_) return lanes_->surface().first_hit(ray, t_max).has_value();
  return tree_ && tree_->any_hit(ray, 0, t_max);
}

double PreparedSurface::local_size_mm(const MeshPoint& point) const {
  if (lanes_) return voxel_diagonal_mm_;
  const auto [a, b, c] = mesh_->triangles[point.triangle];
  return std::max({(*longest_edges_mm_)[a], (*longest_edges_mm_)[b], (*longest_edges_mm_)[c]});
}

std::optional<Vec3> PreparedSurface::true_normal(Vec3 position, const MeshPoint& point) const {
  if (lanes_) return lanes_->surface().true_normal(position);
  const auto [a, b, c] = corners(*mesh_, mesh_->triangles[point.triangle]);
  const Vec3 normal = cross(b - a, c - a);
  if (normal == Vec3{}) return std::nullopt;
  return normalize(normal);
}

double PreparedSurface::t_before(const Ray& ray, double t_hit) const {
  if (lanes_) return lanes_->surface().t_before(ray, t_hit);
  return t_hit - std::min(step_mm_ / length(ray.direction), t_hit / 2);
}

SceneSurfaces::SceneSurfaces(const Scene& scene, const SceneSurfaces* previous) {
  for (const SurfaceItem& item : scene.surfaces) {
    surfaces_.push_back(prepared(item, scene, previous));
  }
}

PreparedSurface SceneSurfaces::prepared(const SurfaceItem& item, const Scene& scene,
                                        const SceneSurfaces* previous) {
  // Made once, here or before.
  const auto kept = [&](auto SceneSurfaces::*map, const auto& key, const auto& make) {
    auto& value = (this->*map)[key];
    if (!value && previous && (previous->*map).contains(key)) value = (previous->*map).at(key);
    if (!value) value = make();
    return value;
  };
  const bool is_raster = scene.visibility == Visibility::kRaster;
  const VolumeAndIso key{item.volume, item.iso};
  if (item.volume && !is_raster) {
    const auto bricks = kept(&SceneSurfaces::bricks_, item.volume,
                             [&] { return std::make_shared<const BrickGrid>(*item.volume); });
    return PreparedSurface(kept(&SceneSurfaces::lanes_, key, [&] {
      return std::make_shared<const IsoLanes>(IsoSurface(item.volume, bricks, item.iso), *bricks);
    }));
  }
  const auto mesh = item.mesh ? item.mesh : kept(&SceneSurfaces::meshes_, key, [&] {
    return std::make_shared<const Mesh>(extract_isosurface(*item.volume, item.iso));
  });
  const bool is_met_by_rays =
      (!is_raster || needs_secondary_rays(scene)) && !mesh->triangles.empty();
  if (!is_met_by_rays) return {mesh, nullptr};
  return {mesh, kept(&SceneSurfaces::trees_, mesh,
                     [&] { return std::make_shared<const MeshSurface>(mesh); })};
}

bool has_further_points(const Scene& scene) {
  return std::ranges::any_of(scene.surfaces, [&](const SurfaceItem& item) {
    return item.material.opacity < 1 || (item.material.kr != Rgb{} && scene.mirror_depth > 0);
  });
}

bool needs_secondary_rays(const Scene& scene) {
  return scene.shadows || scene.indirect != IndirectMethod::kOff || has_further_points(scene);
}

}  // namespace isolux
