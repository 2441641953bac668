#include "isolux/intersect/mesh_surface.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <mutex>
#include <numeric>
#include <string>
#include <vector>

#include "isolux/base/error.h"
#include "isolux/base/instruction_set.h"
#include "isolux/base/memory.h"
#include "isolux/base/parallel.h"
#include "isolux/intersect/aimed_rays.h"
#include "isolux/intersect/ray_triangle.h"

namespace isolux {
namespace {

constexpr int kPacket = AimedRays::kCount;

// Embree counts in floats, about the mesh's middle and from where the ray comes near it, so that it
// is off by some 2^-20 of the mesh's radius at the most. It is asked about more than is wanted, by
// this share of the radius.
constexpr double kSlack = 2e-5;

// Drawing looks at every cluster of triangles, so it is for many rays.
constexpr std::size_t kMostClustersAPacket = 4;

// What the rays of a packet look for, and what they have found; Embree hands it to the functions
// below, which tell lanes apart by the rays' ids.
struct Query : RTCIntersectContext {
  const RayLanes& rays;
  int first;  ///< lane of `rays`
  AimedRays aimed;
  double t_min[kPacket];  ///< excluded
  double t_max[kPacket];
  MeshHit found[kPacket];
  std::uint32_t hit = 0;
  const std::uint32_t* own = nullptr;  ///< of each lane a triangle that does not occlude; or none

  Query(const RayLanes& of, int from, std::uint32_t lanes, const MeshBall& ball)
      : rays(of), first(from) {
    rtcInitIntersectContext(this);
    aim(rays, first, lanes, ball, aimed);
    flags = aimed.run_together ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                               : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    for (int n = 0; n < kPacket; ++n) {
      t_min[n] = rays.begin[first + n];
      t_max[n] = rays.end[first + n];
    }
  }

  // Embree's t that is surely not before ours.
  float embree_t(unsigned lane, double t) const {
    return static_cast<float>(t - aimed.t_start[lane] + aimed.slack[lane]);
  }

  RayTriangles triangles(unsigned lane) const {
    const std::size_t n = static_cast<std::size_t>(first) + lane;
    return RayTriangles({{rays.origin[0][n], rays.origin[1][n], rays.origin[2][n]},
                         {rays.direction[0][n], rays.direction[1][n], rays.direction[2][n]}});
  }
  // Whether the triangle is met, and nearer than what was found; then it is kept.
  bool finds(unsigned lane, std::uint32_t triangle, const std::array<Vec3, 3>& corners) {
    const auto there = triangles(lane).hit(corners);
    if (!there || !(there->t > t_min[lane]) || there->t > t_max[lane]) return false;
    MeshHit& nearest = found[lane];
    const bool is_nearer = !(hit >> lane & 1) || there->t < nearest.t ||
                           (there->t == nearest.t && triangle < nearest.triangle);
    if (!is_nearer) return false;
    nearest = {there->t, triangle, there->u, there->v};
    hit |= 1u << lane;
    return true;
  }
  bool is_occluded(unsigned lane, std::uint32_t triangle,
                   const std::array<Vec3, 3>& corners) const {
    if (own && own[lane] == triangle) return false;
    const auto there = triangles(lane).hit(corners);
    return there && there->t > t_min[lane] && there->t < t_max[lane];
  }
};

// Embree's form of aimed rays. It looks into lanes that are not valid, too.
struct Packet {
  alignas(64) int valid[kPacket];

  Packet(const AimedRays& aimed, RTCRay16& to) {
    const auto copied = [](const float* from, float* there) { std::copy_n(from, kPacket, there); };
    copied(aimed.origin[0], to.org_x);
    copied(aimed.origin[1], to.org_y);
    copied(aimed.origin[2], to.org_z);
    copied(aimed.direction[0], to.dir_x);
    copied(aimed.direction[1], to.dir_y);
    copied(aimed.direction[2], to.dir_z);
    copied(aimed.until, to.tfar);
    for (unsigned n = 0; n < kPacket; ++n) {
      to.tnear[n] = to.time[n] = 0;
      to.mask[n] = ~0u;
      to.id[n] = n;
      to.flags[n] = 0;
      valid[n] = aimed.valid >> n & 1 ? -1 : 0;
    }
  }
};

// One ray in lane 0, for a piece of it that is no shorter.
RayLanes alone(const Ray& ray, double t_min, double t_max) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  RayLanes lanes{};
  for (int axis = 0; axis < 3; ++axis) {
    lanes.origin[axis][0] = ray.origin[axis];
    lanes.direction[axis][0] = ray.direction[axis];
  }
  lanes.begin[0] = std::nextafter(static_cast<float>(t_min), -kInfinity);
  lanes.end[0] = std::nextafter(static_cast<float>(t_max), kInfinity);
  return lanes;
}

const char* device_options() {
  const std::string used = instruction_set_in_use();
  return used == "avx512" ? nullptr : used == "avx2" ? "max_isa=avx2" : "max_isa=sse4.2";
}

}  // namespace

// Embree gets every triangle with a rim as wide as the slack, and what it hits is tried again by
// its filter functions.
class MeshSurface::Tree {
 public:
  Tree(const Mesh& mesh, const MeshBox& box)
      : device_(rtcNewDevice(device_options())), mesh_(mesh) {
    const double radius = 0.5 * length(box.high - box.low);
    ball_ = {0.5 * (box.low + box.high), radius, kSlack * radius};
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    add_triangles();
    rtcCommitScene(scene_);
    if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) {
      release();
      throw WorkError("Embree", "cannot build its tree", "is there enough memory?");
    }
  }
  ~Tree() { release(); }
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;

  const MeshBall& ball() const { return ball_; }

  void first_hits(Query& query) const {
    if (query.aimed.valid == 0) return;
    RTCRayHit16 rays;
    const Packet packet(query.aimed, rays.ray);
    std::fill_n(rays.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(rays.hit.instID[0], kPacket, RTC_INVALID_GEOMETRY_ID);
    rtcIntersect16(packet.valid, scene_, &query, &rays);
  }

  std::uint32_t occluded(Query& query) const {
    if (query.aimed.valid == 0) return 0;
    RTCRay16 rays;
    const Packet packet(query.aimed, rays);
    rtcOccluded16(packet.valid, scene_, &query, &rays);
    std::uint32_t hit = 0;
    for (int n = 0; n < kPacket; ++n) hit |= std::uint32_t{rays.tfar[n] < 0} << n;
    return hit & query.aimed.valid;
  }

 private:
  void release() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  std::array<Vec3, 3> corners_of(std::uint32_t triangle) const {
    return corners(mesh_, mesh_.triangles[triangle]);
  }

  // --- Building ---

  // A triangle with its rim, as one triangle; or, since the rim would make a needle much longer, as
  // the two halves of a box in its plane.
  struct Rimmed {
    std::size_t count = 0;
    std::array<std::array<Vec3, 3>, 2> triangles;

    Rimmed(const std::array<Vec3, 3>& c, double rim) {
      const Vec3 normal = cross(c[1] - c[0], c[2] - c[0]);
      if (normal == Vec3{}) return;  // nothing meets it
      const double a = length(c[2] - c[1]), b = length(c[0] - c[2]), d = length(c[1] - c[0]);
      const double around = a + b + d, inner_radius = length(normal) / around;
      if (inner_radius > rim / 4) {
        const Vec3 middle = (a * c[0] + b * c[1] + d * c[2]) / around;
        const double grown = 1 + rim / inner_radius;
        count = 1;
        for (std::size_t n = 0; n < 3; ++n) triangles[0][n] = middle + grown * (c[n] - middle);
        return;
      }
      const std::size_t apex = a >= b && a >= d ? 0 : b >= d ? 1 : 2;  // over the longest side
      const Vec3 from = c[(apex + 1) % 3], to = c[(apex + 2) % 3];
      const Vec3 along = normalize(to - from), across = cross(normalize(normal), along);
      const double height = dot(c[apex] - from, across);
      const Vec3 low = from - rim * (along + across), high = to + rim * (along - across);
      const Vec3 up = (height + 2 * rim) * across;
      count = 2;
      triangles = {{{low, high, high + up}, {low, high + up, low + up}}};
    }
  };

  void add_triangles() {
    std::vector<Vec3f> vertices;
    vertices.reserve(3 * mesh_.triangles.size());
    for (std::uint32_t n = 0; n < mesh_.triangles.size(); ++n) {
      const Rimmed rimmed(corners_of(n), ball_.slack);
      for (std::size_t part = 0; part < rimmed.count; ++part) {
        triangles_.push_back(n);
        for (const Vec3& corner : rimmed.triangles[part]) {
          vertices.push_back(as_float(corner - ball_.center));
        }
      }
    }
    if (triangles_.empty()) return;
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* to = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                       sizeof(Vec3f), vertices.size());
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), triangles_.size()));
    if (to && indices) {
      std::memcpy(to, vertices.data(), vertices.size() * sizeof(Vec3f));
      std::iota(indices, indices + 3 * triangles_.size(), 0u);
    }
    rtcSetGeometryIntersectFilterFunction(geometry, try_again);
    rtcSetGeometryOccludedFilterFunction(geometry, try_again_any);
    rtcSetGeometryUserData(geometry, this);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
  }

  // --- What Embree calls ---

  // A triangle with its rim is met: is the triangle itself?
  static void try_again(const RTCFilterFunctionNArguments* arguments) {
    const Tree& tree = *static_cast<const Tree*>(arguments->geometryUserPtr);
    auto& query = *static_cast<Query*>(arguments->context);
    for (unsigned n = 0; n < arguments->N; ++n) {
      if (!arguments->valid[n]) continue;
      const unsigned lane = RTCRayN_id(arguments->ray, arguments->N, n);
      const std::uint32_t triangle =
          tree.triangles_[RTCHitN_primID(arguments->hit, arguments->N, n)];
      if (query.finds(lane, triangle, tree.corners_of(triangle))) {
        // From now on Embree looks for what is nearer and, by the slack, for what is as near.
        RTCRayN_tfar(arguments->ray, arguments->N, n) = query.embree_t(lane, query.found[lane].t);
      } else {
        arguments->valid[n] = 0;
      }
    }
  }

  static void try_again_any(const RTCFilterFunctionNArguments* arguments) {
    const Tree& tree = *static_cast<const Tree*>(arguments->geometryUserPtr);
    const auto& query = *static_cast<const Query*>(arguments->context);
    for (unsigned n = 0; n < arguments->N; ++n) {
      if (!arguments->valid[n]) continue;
      const unsigned lane = RTCRayN_id(arguments->ray, arguments->N, n);
      const std::uint32_t triangle =
          tree.triangles_[RTCHitN_primID(arguments->hit, arguments->N, n)];
      if (!query.is_occluded(lane, triangle, tree.corners_of(triangle))) arguments->valid[n] = 0;
    }
  }

  RTCDevice device_;
  RTCScene scene_;
  const Mesh& mesh_;
  MeshBall ball_;
  std::vector<std::uint32_t> triangles_;  ///< by Embree's numbers
};

// Made when they are asked for again: for one picture they would take longer than they spare.
class MeshSurface::Clusters {
 public:
  const std::vector<TriangleCluster>* of(const Mesh& mesh) {
    if (!was_asked_.exchange(true)) return nullptr;
    std::call_once(made_, [&] { clusters_ = cluster_triangles(mesh); });
    return &clusters_;
  }

 private:
  std::atomic<bool> was_asked_ = false;
  std::once_flag made_;
  std::vector<TriangleCluster> clusters_;
};

MeshSurface::MeshSurface(std::shared_ptr<const Mesh> mesh)
    : mesh_(std::move(mesh)), box_(box_of(*mesh_)) {
  constexpr double kBytesOfTriangle = 250;  // its corners here and there, and a share of the tree
  check_memory(kBytesOfTriangle * static_cast<double>(mesh_->triangles.size()), "the mesh's tree");
  // Embree builds in a mode that takes the smallest numbers for 0, and TBB hands the mode that it
  // finds at its first use to every loop after it: so that use is here.
  parallel_for(1, 1, [](std::size_t, std::size_t) {});
  tree_ = std::make_unique<Tree>(*mesh_, box_);
  clusters_ = std::make_unique<Clusters>();
}
MeshSurface::~MeshSurface() = default;
MeshSurface::MeshSurface(MeshSurface&&) noexcept = default;
MeshSurface& MeshSurface::operator=(MeshSurface&&) noexcept = default;

std::optional<MeshHit> MeshSurface::first_hit(const Ray& ray, double t_max) const {
  const RayLanes lanes = alone(ray, 0, t_max);
  Query query(lanes, 0, 1, tree_->ball());
  query.t_min[0] = 0;
  query.t_max[0] = t_max;
  tree_->first_hits(query);
  if (query.hit == 0) return std::nullopt;
  return query.found[0];
}

bool MeshSurface::any_hit(const Ray& ray, double t_min, double t_max) const {
  const RayLanes lanes = alone(ray, t_min, t_max);
  Query query(lanes, 0, 1, tree_->ball());
  query.t_min[0] = t_min;
  query.t_max[0] = t_max;
  return tree_->occluded(query) != 0;
}

void MeshSurface::first_hits(const RayLanes& rays, std::uint32_t lanes, MeshHitLanes& hits) const {
  hits.hit = 0;
  for (int first = 0; first < RayLanes::kCount; first += kPacket) {
    Query query(rays, first, lanes >> first, tree_->ball());
    tree_->first_hits(query);
    hits.hit |= query.hit << first;
    for (std::uint32_t rest = query.hit; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      hits.t[first + n] = query.found[n].t;
      hits.triangle[first + n] = query.found[n].triangle;
    }
  }
}

std::uint32_t MeshSurface::occluded(const RayLanes& rays, std::uint32_t lanes) const {
  std::uint32_t hit = 0;
  for (int first = 0; first < RayLanes::kCount; first += kPacket) {
    Query query(rays, first, lanes >> first, tree_->ball());
    hit |= tree_->occluded(query) << first;
  }
  return hit;
}

void MeshSurface::trace_shadows(const RayTarget& light, ShadowPacket& packet) const {
  static_assert(kPacket == ShadowPacket::kCount);
  RayLanes rays{};
  for (int n = 0; n < ShadowPacket::kCount; ++n) {
    const Ray ray = light.ray_from({packet.origin[0][n], packet.origin[1][n], packet.origin[2][n]});
    for (int axis = 0; axis < 3; ++axis) {
      rays.origin[axis][n] = ray.origin[axis];
      rays.direction[axis][n] = ray.direction[axis];
    }
    rays.begin[n] = packet.begin[n];
    rays.end[n] = static_cast<float>(light.end());
  }
  const auto hidden_among = [&](std::uint32_t lanes) {
    Query query(rays, 0, lanes, tree_->ball());
    query.own = packet.own;
    return tree_->occluded(query);
  };
  packet.far = hidden_among(packet.lanes);
  std::copy_n(rays.begin, ShadowPacket::kCount, rays.end);
  std::fill_n(rays.begin, ShadowPacket::kCount, 0.0f);
  packet.near = hidden_among(packet.lanes & ~packet.far);
}

void MeshSurface::find_shadows(const RayTarget& light, std::span<ShadowPacket> packets) const {
  const auto view = LightView::of(light, tree_->ball());
  const std::size_t clusters = mesh_->triangles.size() / TriangleCluster::kCount;
  if (view && clusters <= kMostClustersAPacket * packets.size()) {
    const auto* drawn = clusters_->of(*mesh_);
    if (drawn && draw_shadows(*mesh_, *drawn, light, *view, packets)) return;
  }
  parallel_for(packets.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) trace_shadows(light, packets[n]);
  });
}

}  // namespace isolux
