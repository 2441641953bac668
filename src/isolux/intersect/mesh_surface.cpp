#include "isolux/intersect/mesh_surface.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>

#include "isolux/base/error.h"
#include "isolux/base/parallel.h"
#include "isolux/intersect/ray_triangle.h"
#include "isolux/mesh/mesh_box.h"

namespace isolux {
namespace {

// Embree counts in floats, about the mesh's middle and from where the ray comes near it, so that it
// is off by some 2^-22 of the mesh's radius at the most. Boxes and bounds are wider by this share,
// so that nothing is lost.
constexpr double kSlack = 4e-6;

// What one ray looks for, and what it has found; Embree hands it to the functions below.
struct Query : RTCIntersectContext {
  explicit Query(const Ray& ray) : triangles(ray) { rtcInitIntersectContext(this); }

  RayTriangles triangles;
  double t_start = 0;  ///< where Embree's ray begins, along ours
  double t_min = 0;    ///< excluded
  double t_max = 0;
  double scale = 0;  ///< our t for one of Embree's
  double slack = 0;
  std::optional<MeshHit> found;

  float embree_t(double t) const { return static_cast<float>((t - t_start) / scale + slack); }
};

bool is_nearer(const TriangleHit& hit, std::uint32_t triangle, const Query& query) {
  if (!(hit.t > query.t_min) || hit.t > query.t_max) return false;
  if (!query.found) return true;
  return hit.t < query.found->t || (hit.t == query.found->t && triangle < query.found->triangle);
}

}  // namespace

struct MeshSurface::Tree {
  RTCDevice device;
  RTCScene scene;
  const Mesh* mesh;
  Vec3 center;
  double radius = 0;

  explicit Tree(const Mesh& of) : device(rtcNewDevice(nullptr)), mesh(&of) {
    const MeshBox box = box_of(of);
    center = 0.5 * (box.low + box.high);
    radius = 0.5 * length(box.high - box.low);
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(of.triangles.size()));
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occlude);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) {
      release();
      throw WorkError("Embree", "cannot build its tree", "is there enough memory?");
    }
  }
  ~Tree() { release(); }
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;

  // Embree's ray for ours, from where it comes near the mesh; nothing where it passes it by.
  std::optional<RTCRay> aim(const Ray& ray, Query& query) const {
    const double speed = length(ray.direction);
    const Vec3 direction = ray.direction / speed;
    const double nearest = dot(center - ray.origin, direction);
    const double reach = radius * (1 + kSlack);
    query.scale = 1 / speed;
    query.slack = kSlack * radius;
    query.t_start = std::max(query.t_min, (nearest - reach) / speed);
    const double end = std::min(query.t_max, (nearest + reach) / speed);
    if (!(query.t_start <= end)) return std::nullopt;
    const Vec3 origin = ray.at(query.t_start) - center;
    RTCRay to{};
    to.org_x = static_cast<float>(origin.x);
    to.org_y = static_cast<float>(origin.y);
    to.org_z = static_cast<float>(origin.z);
    to.dir_x = static_cast<float>(direction.x);
    to.dir_y = static_cast<float>(direction.y);
    to.dir_z = static_cast<float>(direction.z);
    to.tfar = query.embree_t(end);
    to.mask = ~0u;
    return to;
  }

 private:
  void release() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }

  static void bounds(const RTCBoundsFunctionArguments* arguments) {
    const Tree& tree = *static_cast<const Tree*>(arguments->geometryUserPtr);
    const auto points = corners(*tree.mesh, tree.mesh->triangles[arguments->primID]);
    const double slack = kSlack * tree.radius;
    const auto low = [&](int axis) {
      const double least = std::min({points[0][axis], points[1][axis], points[2][axis]});
      return static_cast<float>(least - tree.center[axis] - slack);
    };
    const auto high = [&](int axis) {
      const double most = std::max({points[0][axis], points[1][axis], points[2][axis]});
      return static_cast<float>(most - tree.center[axis] + slack);
    };
    RTCBounds& to = *arguments->bounds_o;
    to.lower_x = low(0);
    to.lower_y = low(1);
    to.lower_z = low(2);
    to.upper_x = high(0);
    to.upper_y = high(1);
    to.upper_z = high(2);
  }

  static void intersect(const RTCIntersectFunctionNArguments* arguments) {
    const Tree& tree = *static_cast<const Tree*>(arguments->geometryUserPtr);
    auto& query = *static_cast<Query*>(arguments->context);
    const std::uint32_t triangle = arguments->primID;
    const auto hit = query.triangles.hit(corners(*tree.mesh, tree.mesh->triangles[triangle]));
    if (!hit || !is_nearer(*hit, triangle, query)) return;
    query.found = MeshHit{hit->t, triangle, hit->u, hit->v};
    // Embree asks for what is nearer, and, by the slack, for what is as near.
    auto& ray = reinterpret_cast<RTCRayHit*>(arguments->rayhit)->ray;
    ray.tfar = std::min(ray.tfar, query.embree_t(hit->t));
  }

  static void occlude(const RTCOccludedFunctionNArguments* arguments) {
    const Tree& tree = *static_cast<const Tree*>(arguments->geometryUserPtr);
    const auto& query = *static_cast<const Query*>(arguments->context);
    const auto hit =
        query.triangles.hit(corners(*tree.mesh, tree.mesh->triangles[arguments->primID]));
    if (!hit || !(hit->t > query.t_min && hit->t < query.t_max)) return;
    reinterpret_cast<RTCRay*>(arguments->ray)->tfar = -std::numeric_limits<float>::infinity();
  }
};

MeshSurface::MeshSurface(std::shared_ptr<const Mesh> mesh) : mesh_(std::move(mesh)) {
  // Embree builds in a mode that takes the smallest numbers for 0, and TBB hands the mode that it
  // finds at its first use to every loop after it: so that use is here.
  parallel_for(1, 1, [](std::size_t, std::size_t) {});
  tree_ = std::make_unique<Tree>(*mesh_);
}
MeshSurface::~MeshSurface() = default;
MeshSurface::MeshSurface(MeshSurface&&) noexcept = default;
MeshSurface& MeshSurface::operator=(MeshSurface&&) noexcept = default;

std::optional<MeshHit> MeshSurface::first_hit(const Ray& ray, double t_max) const {
  Query query(ray);
  query.t_max = t_max;
  const auto aimed = tree_->aim(ray, query);
  if (!aimed) return std::nullopt;
  RTCRayHit asked{};
  asked.ray = *aimed;
  asked.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(tree_->scene, &query, &asked);
  return query.found;
}

bool MeshSurface::any_hit(const Ray& ray, double t_min, double t_max) const {
  Query query(ray);
  query.t_min = t_min;
  query.t_max = t_max;
  auto asked = tree_->aim(ray, query);
  if (!asked) return false;
  rtcOccluded1(tree_->scene, &query, &*asked);
  return asked->tfar < 0;
}

}  // namespace isolux
