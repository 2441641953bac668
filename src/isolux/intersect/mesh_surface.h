#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "isolux/base/ray.h"
#include "isolux/intersect/iso_lanes.h"
#include "isolux/intersect/shadow_raster.h"
#include "isolux/mesh/mesh.h"
#include "isolux/mesh/mesh_box.h"

namespace isolux {

/// Where a ray meets a mesh: at t, in a triangle, at the point (1 - u - v) a + u b + v c of its
/// corners.
struct MeshHit {
  double t;
  std::uint32_t triangle;
  double u;
  double v;
};

/// The same of rays side by side.
struct MeshHitLanes {
  std::uint32_t hit = 0;  ///< bit n: lane n; the rest of a lane that has no hit is not defined
  double t[RayLanes::kCount];
  std::uint32_t triangle[RayLanes::kCount];  ///< where in it, find_mesh_points tells
};

/// A mesh for rays in world space. Embree says which triangles may be met; whether and where they
/// are is computed here, in doubles (RayTriangles). So the answer is that of trying all triangles,
/// on every machine; of several at the same t it is the lowest number.
class MeshSurface {
 public:
  /// Builds the tree, on all threads. The mesh must have triangles; it is kept.
  explicit MeshSurface(std::shared_ptr<const Mesh> mesh);
  ~MeshSurface();
  MeshSurface(MeshSurface&&) noexcept;
  MeshSurface& operator=(MeshSurface&&) noexcept;

  /// The first hit along the ray with 0 < t <= t_max.
  std::optional<MeshHit> first_hit(const Ray& ray,
                                   double t_max = std::numeric_limits<double>::infinity()) const;
  /// Whether anything is hit with t_min < t < t_max.
  bool any_hit(const Ray& ray, double t_min, double t_max) const;

  /// The same for each lane whose bit is in `lanes`, with the rays in world space: the first hit
  /// with begin < t <= end.
  void first_hits(const RayLanes& rays, std::uint32_t lanes, MeshHitLanes& hits) const;
  /// The lanes that hit anything with begin < t < end.
  std::uint32_t occluded(const RayLanes& rays, std::uint32_t lanes) const;
  /// The same of many rays to one light, by whichever way is quicker: `far` and `near` of each
  /// packet are set. On all threads.
  void find_shadows(const RayTarget& light, std::span<ShadowPacket> packets) const;

  const Mesh& mesh() const { return *mesh_; }
  const MeshBox& box() const { return box_; }

 private:
  class Tree;
  class Clusters;

  void trace_shadows(const RayTarget& light, ShadowPacket& packet) const;

  std::shared_ptr<const Mesh> mesh_;
  MeshBox box_;
  std::unique_ptr<Tree> tree_;
  std::unique_ptr<Clusters> clusters_;
};

}  // namespace isolux
