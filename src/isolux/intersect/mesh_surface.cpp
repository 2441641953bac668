#include "isolux/intersect/mesh_surface.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>
#include <vector>

#include "isolux/base/error.h"
#include "isolux/base/instruction_set.h"
#include "isolux/base/parallel.h"
#include "isolux/intersect/ray_triangle.h"
#include "isolux/mesh/mesh_box.h"

namespace isolux {
namespace {

constexpr int kPacket = 16;  // rays that Embree takes together

// Embree counts in floats, about the mesh's middle and from where the ray comes near it, so that it
// is off by some 2^-20 of the mesh's radius at the most. It is asked about more than is wanted, by
// this share of the radius.
constexpr double kSlack = 2e-5;

// What the rays of a packet look for, and what they have found; Embree hands it to the functions
// below, which tell lanes apart by the rays' ids.
struct Query : RTCIntersectContext {
  Query() { rtcInitIntersectContext(this); }

  Ray rays[kPacket];
  double t_min[kPacket];  ///< excluded
  double t_max[kPacket];
  double t_start[kPacket];  ///< where Embree's ray begins, along ours
  double slack[kPacket];    ///< in t
  MeshHit found[kPacket];
  std::uint32_t hit = 0;

  void set(int lane, const Ray& ray, double after, double until) {
    rays[lane] = ray;
    t_min[lane] = after;
    t_max[lane] = until;
  }

  // Embree's t that is surely not before ours.
  float embree_t(unsigned lane, double t) const {
    return static_cast<float>(t - t_start[lane] + slack[lane]);
  }

  // Whether the triangle is met, and nearer than what was found; then it is kept.
  bool finds(unsigned lane, std::uint32_t triangle, const std::array<Vec3, 3>& corners) {
    const auto there = RayTriangles(rays[lane]).hit(corners);
    if (!there || !(there->t > t_min[lane]) || there->t > t_max[lane]) return false;
    MeshHit& nearest = found[lane];
    const bool is_nearer = !(hit >> lane & 1) || there->t < nearest.t ||
                           (there->t == nearest.t && triangle < nearest.triangle);
    if (!is_nearer) return false;
    nearest = {there->t, triangle, there->u, there->v};
    hit |= 1u << lane;
    return true;
  }
  bool is_occluded(unsigned lane, const std::array<Vec3, 3>& corners) const {
    const auto there = RayTriangles(rays[lane]).hit(corners);
    return there && there->t > t_min[lane] && there->t < t_max[lane];
  }
};

// Calls use(query, first lane, lanes of the query) for each sixteen rays that hold wanted ones.
template <typename Use>
void for_each_packet(const RayLanes& rays, std::uint32_t lanes, const Use& use) {
  for (int first = 0; first < RayLanes::kCount; first += kPacket) {
    const std::uint32_t of_packet = lanes >> first & 0xffff;
    if (of_packet == 0) continue;
    Query query;
    for (int n = 0; n < kPacket; ++n) {
      const int lane = first + n;
      const Ray ray{{rays.origin[0][lane], rays.origin[1][lane], rays.origin[2][lane]},
                    {rays.direction[0][lane], rays.direction[1][lane], rays.direction[2][lane]}};
      query.set(n, ray, rays.begin[lane], rays.end[lane]);
    }
    use(query, first, of_packet);
  }
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
  explicit Tree(const Mesh& mesh) : device_(rtcNewDevice(device_options())), mesh_(mesh) {
    const MeshBox box = box_of(mesh);
    center_ = 0.5 * (box.low + box.high);
    radius_ = 0.5 * length(box.high - box.low);
    slack_ = kSlack * radius_;
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

  void first_hits(Query& query, std::uint32_t lanes) const {
    RTCRayHit16 packet{};  // Embree 3.13 looks into lanes that are not valid, too
    alignas(64) int valid[kPacket];
    if (!aim(query, lanes, packet.ray, valid)) return;
    query.flags = go_together(packet.ray, valid) ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                 : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(packet.hit.instID[0], kPacket, RTC_INVALID_GEOMETRY_ID);
    rtcIntersect16(valid, scene_, &query, &packet);
  }

  std::uint32_t occluded(Query& query, std::uint32_t lanes) const {
    RTCRay16 packet{};
    alignas(64) int valid[kPacket];
    if (!aim(query, lanes, packet, valid)) return 0;
    query.flags = go_together(packet, valid) ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                             : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcOccluded16(valid, scene_, &query, &packet);
    std::uint32_t hit = 0;
    for (int n = 0; n < kPacket; ++n) {
      if (valid[n] && packet.tfar[n] < 0) hit |= 1u << n;
    }
    return hit;
  }

 private:
  void release() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  // Embree's rays for ours, from where they come near the mesh. Whether any does.
  bool aim(Query& query, std::uint32_t lanes, RTCRay16& to, int* valid) const {
    bool any = false;
    const double reach = radius_ + 2 * slack_;
    for (unsigned n = 0; n < kPacket; ++n) {
      valid[n] = 0;
      if (!(lanes >> n & 1)) continue;
      const Vec3 o = query.rays[n].origin - center_, d = query.rays[n].direction;
      const double per_square = 1 / dot(d, d), per_length = std::sqrt(per_square);
      const double nearest = -dot(o, d) * per_square;
      const double begin = std::max(query.t_min[n], nearest - reach * per_length);
      const double end = std::min(query.t_max[n], nearest + reach * per_length);
      if (!(begin <= end)) continue;
      query.slack[n] = slack_ * per_length;
      query.t_start[n] = begin - 2 * query.slack[n];
      const Vec3 start = o + query.t_start[n] * d;
      to.org_x[n] = static_cast<float>(start.x);
      to.org_y[n] = static_cast<float>(start.y);
      to.org_z[n] = static_cast<float>(start.z);
      to.dir_x[n] = static_cast<float>(d.x);
      to.dir_y[n] = static_cast<float>(d.y);
      to.dir_z[n] = static_cast<float>(d.z);
      to.tnear[n] = 0;
      to.tfar[n] = query.embree_t(n, end);
      to.time[n] = 0;
      to.mask[n] = ~0u;
      to.id[n] = n;
      to.flags[n] = 0;
      valid[n] = -1;
      any = true;
    }
    return any;
  }

  // Whether Embree should take them through its tree as one: where all run the same way.
  static bool go_together(const RTCRay16& rays, const int* valid) {
    bool same[3][2] = {{true, true}, {true, true}, {true, true}};
    const float* directions[3] = {rays.dir_x, rays.dir_y, rays.dir_z};
    for (int n = 0; n < kPacket; ++n) {
      if (!valid[n]) continue;
      for (int axis = 0; axis < 3; ++axis) {
        same[axis][0] &= directions[axis][n] >= 0;
        same[axis][1] &= directions[axis][n] <= 0;
      }
    }
    return std::ranges::all_of(same, [](const bool(&ways)[2]) { return ways[0] || ways[1]; });
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
      const Rimmed rimmed(corners_of(n), slack_);
      for (std::size_t part = 0; part < rimmed.count; ++part) {
        triangles_.push_back(n);
        for (const Vec3& corner : rimmed.triangles[part]) {
          vertices.push_back(as_float(corner - center_));
        }
      }
    }
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
      if (!query.is_occluded(lane, tree.corners_of(triangle))) arguments->valid[n] = 0;
    }
  }

  RTCDevice device_;
  RTCScene scene_;
  const Mesh& mesh_;
  Vec3 center_;
  double radius_ = 0, slack_ = 0;         ///< mm
  std::vector<std::uint32_t> triangles_;  ///< by Embree's numbers
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
  Query query;
  query.set(0, ray, 0, t_max);
  tree_->first_hits(query, 1);
  if (query.hit == 0) return std::nullopt;
  return query.found[0];
}

bool MeshSurface::any_hit(const Ray& ray, double t_min, double t_max) const {
  Query query;
  query.set(0, ray, t_min, t_max);
  return tree_->occluded(query, 1) != 0;
}

void MeshSurface::first_hits(const RayLanes& rays, std::uint32_t lanes, MeshHitLanes& hits) const {
  hits.hit = 0;
  for_each_packet(rays, lanes, [&](Query& query, int first, std::uint32_t of_packet) {
    tree_->first_hits(query, of_packet);
    hits.hit |= query.hit << first;
    std::copy_n(query.found, kPacket, hits.hits + first);
  });
}

std::uint32_t MeshSurface::occluded(const RayLanes& rays, std::uint32_t lanes) const {
  std::uint32_t hit = 0;
  for_each_packet(rays, lanes, [&](Query& query, int first, std::uint32_t of_packet) {
    hit |= tree_->occluded(query, of_packet) << first;
  });
  return hit;
}

}  // namespace isolux
