// Embree as a peer of isolux: rays against the mesh that VTK extracts, with its normals
// interpolated.
//   embree_peer THREADS      then the requests of bench/README.md on standard input

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "embree_frame.h"
#include "isolux/bench/line_protocol.h"
#include "isolux/bench/ppm.h"

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPacket = 16;  // rays

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

struct Vec3d {
  double x, y, z;
};

Vec3d read_vec3(std::istringstream& words) {
  Vec3d v{};
  words >> v.x >> v.y >> v.z;
  return v;
}

Vec3d unit(Vec3d a) {
  const double size = std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
  return {a.x / size, a.y / size, a.z / size};
}

Vec3f single(Vec3d a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

// The camera looks from `eye` to `target`; up is +z.
PeerCamera camera_at(Vec3d eye, Vec3d target, double fov_deg) {
  const Vec3d f = unit({target.x - eye.x, target.y - eye.y, target.z - eye.z});
  const Vec3d r = unit({f.y, -f.x, 0});                                                // f x z
  const Vec3d u{r.y * f.z - r.z * f.y, r.z * f.x - r.x * f.z, r.x * f.y - r.y * f.x};  // r x f
  return {single(eye), single(r), single(u), single(f),
          static_cast<float>(std::tan(fov_deg * 3.14159265358979323846 / 360))};
}

struct StoredRay {
  float origin[3], direction[3];
};

std::vector<StoredRay> read_rays(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<StoredRay> rays;
  for (StoredRay ray{}; file.read(reinterpret_cast<char*>(&ray), sizeof ray);) rays.push_back(ray);
  return rays;
}

class EmbreePeer {
 public:
  explicit EmbreePeer(const std::string& threads)
      : device_(rtcNewDevice(("threads=" + threads).c_str())) {}
  ~EmbreePeer() {
    if (scene_) rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreePeer(const EmbreePeer&) = delete;
  EmbreePeer& operator=(const EmbreePeer&) = delete;

  std::string name() const {
    const auto part = [&](RTCDeviceProperty property) {
      return std::to_string(rtcGetDeviceProperty(device_, property));
    };
    return "Embree " + part(RTC_DEVICE_PROPERTY_VERSION_MAJOR) + "." +
           part(RTC_DEVICE_PROPERTY_VERSION_MINOR) + "." + part(RTC_DEVICE_PROPERTY_VERSION_PATCH);
  }

  std::string size(std::istringstream& words) {
    words >> picture_.width >> picture_.height;
    if (picture_.width % 4 != 0 || picture_.height % 4 != 0) {
      throw std::runtime_error("packets of 4x4 pixels need sides that are multiples of 4");
    }
    picture_.rgb.resize(3 * static_cast<std::size_t>(picture_.width) *
                        static_cast<std::size_t>(picture_.height));
    return {};
  }

  std::string mesh(std::istringstream& words) {
    std::string path;
    words >> path;
    mesh_ = isolux::read_peer_mesh(path);
    const auto begin = Clock::now();
    build();
    return std::to_string(ms_since(begin));
  }

  std::string lamp(std::istringstream& words) {
    lamp_ = {true, single(read_vec3(words))};
    return {};
  }

  std::string headlight(std::istringstream&) {
    lamp_.is_point = false;
    return {};
  }

  std::string frame(std::istringstream& words) {
    const Vec3d eye = read_vec3(words), target = read_vec3(words);
    double fov_deg = 0;
    words >> fov_deg;
    check_scene();
    const PeerCamera camera = camera_at(eye, target, fov_deg);
    const Vec3f f = camera.forward;
    if (!lamp_.is_point) lamp_.place = {-f.x, -f.y, -f.z};
    const auto begin = Clock::now();
    const std::size_t hits = draw_frame(scene_, mesh_, camera, lamp_, picture_);
    const double ms = ms_since(begin);
    const auto sum = isolux::checksum_of(picture_.rgb.data(), picture_.rgb.size());
    return std::to_string(ms) + " " + std::to_string(hits) + " " + std::to_string(sum);
  }

  // The nearest hit of each ray, one ray at a time: in packets these are no faster, since each goes
  // its own way.
  std::string rays(std::istringstream& words) {
    return count_rays(words, [this](const StoredRay* rays, std::size_t count) {
      std::size_t hits = 0;
      for (std::size_t n = 0; n < count; ++n) hits += meets(rays[n]);
      return hits;
    });
  }

  // Whether anything is in each ray's way, in packets: these lie side by side.
  std::string shadows(std::istringstream& words) {
    return count_rays(words, [this](const StoredRay* rays, std::size_t count) {
      return shadowed(rays, static_cast<int>(count));
    });
  }

  std::string picture(std::istringstream& words) {
    std::string path;
    words >> path;
    isolux::write_ppm(path, picture_.width, picture_.height, picture_.rgb);
    return {};
  }

 private:
  void check_scene() const {
    if (!scene_) throw std::runtime_error("there is no mesh; send `read-mesh` first");
  }

  void build() {
    if (scene_) rtcReleaseScene(scene_);
    scene_ = rtcNewScene(device_);
    const RTCGeometry triangles = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    // Embree reads a vertex with 16 bytes, so the last needs room behind it.
    mesh_.positions.reserve(mesh_.positions.size() + 1);
    rtcSetSharedGeometryBuffer(triangles, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh_.positions.data(), 0, 3 * sizeof(float),
                               mesh_.positions.size() / 3);
    rtcSetSharedGeometryBuffer(triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh_.triangles.data(), 0, 3 * sizeof(std::uint32_t),
                               mesh_.triangles.size() / 3);
    rtcCommitGeometry(triangles);
    rtcAttachGeometry(scene_, triangles);
    rtcReleaseGeometry(triangles);
    rtcCommitScene(scene_);
  }

  bool meets(const StoredRay& stored) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit hit{};
    hit.ray.org_x = stored.origin[0];
    hit.ray.org_y = stored.origin[1];
    hit.ray.org_z = stored.origin[2];
    hit.ray.dir_x = stored.direction[0];
    hit.ray.dir_y = stored.direction[1];
    hit.ray.dir_z = stored.direction[2];
    hit.ray.tfar = 1e30f;
    hit.ray.mask = 0xffffffff;
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &hit);
    return hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }

  std::size_t shadowed(const StoredRay* rays, int count) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) RTCRay16 packet;
    alignas(64) int valid[kPacket];
    for (int n = 0; n < kPacket; ++n) {
      const StoredRay& stored = rays[std::min(n, count - 1)];
      packet.org_x[n] = stored.origin[0];
      packet.org_y[n] = stored.origin[1];
      packet.org_z[n] = stored.origin[2];
      packet.dir_x[n] = stored.direction[0];
      packet.dir_y[n] = stored.direction[1];
      packet.dir_z[n] = stored.direction[2];
      packet.tnear[n] = packet.time[n] = 0;
      packet.tfar[n] = 1e30f;
      packet.mask[n] = 0xffffffff;
      packet.flags[n] = 0;
      valid[n] = n < count ? -1 : 0;
    }
    rtcOccluded16(valid, scene_, &context, &packet);
    std::size_t hits = 0;
    for (int n = 0; n < count && n < kPacket; ++n) hits += packet.tfar[n] < 0;
    return hits;
  }

  // `hits_of` gets up to kPacket rays that follow each other.
  template <typename HitsOf>
  std::string count_rays(std::istringstream& words, const HitsOf& hits_of) const {
    std::string path;
    words >> path;
    check_scene();
    const std::vector<StoredRay> rays = read_rays(path);
    const std::size_t packets = (rays.size() + kPacket - 1) / kPacket;
    std::atomic<std::size_t> hits{0};
    const auto begin = Clock::now();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, packets, 256), [&](const auto& range) {
      std::size_t here = 0;
      for (std::size_t n = range.begin(); n < range.end(); ++n) {
        const std::size_t left = rays.size() - kPacket * n;
        here += hits_of(rays.data() + kPacket * n, std::min<std::size_t>(left, kPacket));
      }
      hits += here;
    });
    return std::to_string(ms_since(begin)) + " " + std::to_string(hits);
  }

  RTCDevice device_;
  RTCScene scene_ = nullptr;
  Mesh mesh_;
  Lamp lamp_{};
  isolux::Ppm picture_;
};

}  // namespace

int main(int count, char** arguments) {
  const std::string threads = count > 1 ? arguments[1] : "1";
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  std::strtoul(threads.c_str(), nullptr, 10));
  EmbreePeer peer(threads);
  const auto answering = [&](std::string (EmbreePeer::*answer)(std::istringstream&)) {
    return [&peer, answer](std::istringstream& words) { return (peer.*answer)(words); };
  };
  isolux::answer_requests(peer.name(), {{"size", answering(&EmbreePeer::size)},
                                        {"read-mesh", answering(&EmbreePeer::mesh)},
                                        {"lamp", answering(&EmbreePeer::lamp)},
                                        {"headlight", answering(&EmbreePeer::headlight)},
                                        {"frame", answering(&EmbreePeer::frame)},
                                        {"rays", answering(&EmbreePeer::rays)},
                                        {"shadows", answering(&EmbreePeer::shadows)},
                                        {"picture", answering(&EmbreePeer::picture)}});
}
