#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "isolux/intersect/iso_lanes.h"
#include "isolux/intersect/mesh_surface.h"
#include "isolux/render/ray_packet.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// One of Scene::surfaces, made ready for rays: an isosurface or a mesh.
class PreparedSurface {
 public:
  explicit PreparedSurface(std::shared_ptr<const IsoLanes> lanes);
  /// @param tree  null where the mesh is only rasterised.
  PreparedSurface(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const MeshSurface> tree);

  const IsoLanes* lanes() const { return lanes_.get(); }  ///< null: it is a mesh
  const Mesh* mesh() const { return mesh_.get(); }
  const std::shared_ptr<const MeshSurface>& tree() const { return tree_; }

  /// The first hits between begin and end that are nearer than what `hits` has, as of surface
  /// `number`.
  void first_hits(const RayPacket& rays, std::uint32_t lanes, std::int32_t number,
                  PacketHits& hits) const;
  /// The same for many packets, each lane for itself, which is quicker. Of as many `lanes` and
  /// `hits` as there are `rays`.
  void first_hits(std::span<const RayPacket> rays, std::span<const std::uint32_t> lanes,
                  std::int32_t number, std::span<PacketHits> hits) const;
  /// Whether there is any, for each lane: takes from `lanes` those that have none.
  void any_hits(std::span<const RayPacket> rays, std::span<std::uint32_t> lanes) const;
  /// The same for one ray in doubles, with 0 < t < t_max.
  bool any_hit(const Ray& ray, double t_max) const;

  /// Within this distance of a point, in mm, the surface may hide a light from itself only because
  /// its shading normal is smoother than it is: a voxel's diagonal, or the longest edge at the
  /// triangle's corners.
  double local_size_mm(const MeshPoint& point) const;
  /// The unit normal of the surface itself, without smoothing, of either direction; nothing where
  /// there is none.
  std::optional<Vec3> true_normal(Vec3 position, const MeshPoint& point) const;
  /// Where a secondary ray starts: on the ray that met the surface at t_hit, on the side that it
  /// came from, no further off the surface than the error of the hit.
  double t_before(const Ray& ray, double t_hit) const;
  /// A distance in mm, larger than the error of a hit, after which the next crossing along a ray is
  /// looked for.
  double step_mm() const { return step_mm_; }

 private:
  void first_hits_of_mesh(const RayPacket& rays, std::uint32_t lanes, std::int32_t number,
                          PacketHits& hits) const;

  std::shared_ptr<const IsoLanes> lanes_;
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const MeshSurface> tree_;
  double voxel_diagonal_mm_ = 0;
  std::shared_ptr<const std::vector<float>> longest_edges_mm_;  ///< at each vertex of a mesh
  double step_mm_ = 0;
};

/// All surfaces of a scene. Holds what rays need: min-max bricks, one set for each volume; skip
/// structures, one for each volume and iso value; Embree's trees, one for each mesh; or, to
/// rasterise, the meshes of isosurfaces.
class SceneSurfaces {
 public:
  /// Builds what `previous` does not have; neither argument is kept.
  SceneSurfaces(const Scene& scene, const SceneSurfaces* previous);

  /// As in Scene::surfaces.
  const std::vector<PreparedSurface>& all() const { return surfaces_; }
  const PreparedSurface& at(std::int32_t number) const {
    return surfaces_[static_cast<std::size_t>(number)];
  }

 private:
  using VolumeAndIso = std::pair<std::shared_ptr<const Volume>, double>;

  PreparedSurface prepared(const SurfaceItem& item, const Scene& scene,
                           const SceneSurfaces* previous);

  std::map<std::shared_ptr<const Volume>, std::shared_ptr<const BrickGrid>> bricks_;
  std::map<VolumeAndIso, std::shared_ptr<const IsoLanes>> lanes_;
  std::map<VolumeAndIso, std::shared_ptr<const Mesh>> meshes_;
  std::map<std::shared_ptr<const Mesh>, std::shared_ptr<const MeshSurface>> trees_;
  std::vector<PreparedSurface> surfaces_;
};

/// Whether rays other than those from the eye are asked for: shadows, indirect light, mirrors, what
/// lies behind translucent surfaces.
bool needs_secondary_rays(const Scene& scene);
/// Whether a pixel's colour may come from more than one point: mirrors or translucent surfaces.
bool has_further_points(const Scene& scene);

}  // namespace isolux
