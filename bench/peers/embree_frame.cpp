#include "embree_frame.h"

#include <pmmintrin.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace {

constexpr int kLanes = 16;
constexpr int kSide = 4;      // pixels along a packet's side
constexpr int kTileSide = 4;  // packets along a tile's side: one task

constexpr float kAmbient = .1f, kDiffuse = .8f, kSpecular = .3f;

// Display by table: kinder to this side than isolux's own exact curve.
constexpr int kSteps = 8192;

std::array<std::uint8_t, kSteps + 1> make_srgb_table() {
  std::array<std::uint8_t, kSteps + 1> table{};
  for (int n = 0; n <= kSteps; ++n) {
    const double linear = static_cast<double>(n) / kSteps;
    const double curved =
        linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    table[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(std::lround(255 * curved));
  }
  return table;
}

const std::array<std::uint8_t, kSteps + 1> kSrgb = make_srgb_table();

Vec3f operator+(Vec3f a, Vec3f b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3f operator-(Vec3f a, Vec3f b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3f operator*(float s, Vec3f a) { return {s * a.x, s * a.y, s * a.z}; }
float dot(Vec3f a, Vec3f b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec3f unit(Vec3f a) { return (1 / std::sqrt(dot(a, a) + 1e-30f)) * a; }

float to_the_40th(float x) {
  const float x2 = x * x, x4 = x2 * x2, x8 = x4 * x4, x16 = x8 * x8;
  return x16 * x16 * x8;
}

struct alignas(64) Packet {
  RTCRayHit16 rays;
  int valid[kLanes];
};

class FrameTask {
 public:
  FrameTask(RTCScene scene, const Mesh& mesh, const PeerCamera& camera, const Lamp& lamp,
            isolux::Ppm& picture)
      : scene_(scene), mesh_(mesh), camera_(camera), lamp_(lamp), picture_(picture) {}

  std::size_t draw_packet(int x0, int y0) const {
    Packet packet;
    aim(packet, x0, y0);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(packet.valid, scene_, &context, &packet.rays);
    std::size_t hits = 0;
    for (int n = 0; n < kLanes; ++n) hits += packet.rays.hit.geomID[n] == 0;
    if (hits == 0) {
      for (int row = 0; row < kSide; ++row) std::fill_n(pixel(x0, y0 + row), 3 * kSide, 0);
    } else {
      shade(packet, x0, y0);
    }
    return hits;
  }

 private:
  void aim(Packet& packet, int x0, int y0) const {
    const float pixel_size = 2 * camera_.half_height / static_cast<float>(picture_.height);
    const float left = (static_cast<float>(x0) + .5f - .5f * static_cast<float>(picture_.width));
    const float top = (.5f * static_cast<float>(picture_.height) - static_cast<float>(y0) - .5f);
    RTCRay16& ray = packet.rays.ray;
#pragma GCC ivdep
    for (int n = 0; n < kLanes; ++n) {
      const float to_right = (left + static_cast<float>(n % kSide)) * pixel_size;
      const float to_top = (top - static_cast<float>(n / kSide)) * pixel_size;
      const Vec3f d = unit(camera_.forward + to_right * camera_.right + to_top * camera_.up);
      ray.org_x[n] = camera_.eye.x;
      ray.org_y[n] = camera_.eye.y;
      ray.org_z[n] = camera_.eye.z;
      ray.dir_x[n] = d.x;
      ray.dir_y[n] = d.y;
      ray.dir_z[n] = d.z;
      ray.tnear[n] = 0;
      ray.tfar[n] = 1e30f;
      ray.time[n] = 0;
      ray.mask[n] = 0xffffffff;
      ray.flags[n] = 0;
      packet.rays.hit.geomID[n] = RTC_INVALID_GEOMETRY_ID;
      packet.rays.hit.instID[0][n] = RTC_INVALID_GEOMETRY_ID;
      packet.valid[n] = -1;
    }
  }

  // Written so that the compiler can do all lanes at once: no branches, every lane to the end.
  void shade(const Packet& packet, int x0, int y0) const {
    const RTCRay16& ray = packet.rays.ray;
    const float* normals = mesh_.normals.data();
    const std::uint32_t* triangles = mesh_.triangles.data();
    const PeerCamera camera = camera_;
    const Vec3f lamp = lamp_.place;
    const float point_weight = lamp_.is_point ? 1.f : 0.f;
    alignas(64) int index[kLanes];
#pragma GCC ivdep
    for (int n = 0; n < kLanes; ++n) {
      const bool hit = packet.rays.hit.geomID[n] == 0;
      const std::uint32_t triangle = hit ? 3 * packet.rays.hit.primID[n] : 0;
      const float u = hit ? packet.rays.hit.u[n] : 0.f, v = hit ? packet.rays.hit.v[n] : 0.f;
      const std::uint32_t a = 3 * triangles[triangle], b = 3 * triangles[triangle + 1],
                          c = 3 * triangles[triangle + 2];
      const float w = 1 - u - v;
      const Vec3f outward = unit({w * normals[a] + u * normals[b] + v * normals[c],
                                  w * normals[a + 1] + u * normals[b + 1] + v * normals[c + 1],
                                  w * normals[a + 2] + u * normals[b + 2] + v * normals[c + 2]});
      const Vec3f direction{ray.dir_x[n], ray.dir_y[n], ray.dir_z[n]};
      const Vec3f normal = (dot(outward, direction) > 0 ? -1.f : 1.f) * outward;
      const Vec3f point = camera.eye + (hit ? ray.tfar[n] : 0.f) * direction;
      const float light = radiance(normal, direction, unit(lamp - point_weight * point));
      const int step = static_cast<int>(std::min(light, 1.f) * kSteps + .5f);
      index[n] = hit ? step : 0;
    }
    for (int row = 0; row < kSide; ++row) {
      std::uint8_t* out = pixel(x0, y0 + row);
      for (int column = 0; column < kSide; ++column) {
        std::fill_n(out + 3 * column, 3,
                    kSrgb[static_cast<std::size_t>(index[kSide * row + column])]);
      }
    }
  }

  // The reflection model of the contract; every lamp has intensity 1, and so has the ambient light.
  static float radiance(Vec3f normal, Vec3f direction, Vec3f to_light) {
    const float cos_theta = dot(normal, to_light);
    const Vec3f reflected = 2 * cos_theta * normal - to_light;
    const float highlight = kSpecular * to_the_40th(std::max(0.f, -dot(reflected, direction)));
    return kAmbient + (cos_theta > 0 ? kDiffuse * cos_theta + highlight : 0.f);
  }

  std::uint8_t* pixel(int x, int y) const {
    return picture_.rgb.data() +
           3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) +
                static_cast<std::size_t>(x));
  }

  RTCScene scene_;
  const Mesh& mesh_;
  const PeerCamera& camera_;
  const Lamp& lamp_;
  isolux::Ppm& picture_;
};

}  // namespace

std::size_t draw_frame(RTCScene scene, const Mesh& mesh, const PeerCamera& camera, const Lamp& lamp,
                       isolux::Ppm& picture) {
  const FrameTask task(scene, mesh, camera, lamp, picture);
  std::atomic<std::size_t> hits{0};
  const tbb::blocked_range2d<int> packets(0, picture.height / kSide, kTileSide, 0,
                                          picture.width / kSide, 4 * kTileSide);
  tbb::parallel_for(packets, [&](const tbb::blocked_range2d<int>& range) {
    // Denormals as zero, as Embree's manual advises, on whichever thread this is.
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    std::size_t here = 0;
    for (int row = range.rows().begin(); row < range.rows().end(); ++row) {
      for (int column = range.cols().begin(); column < range.cols().end(); ++column) {
        here += task.draw_packet(kSide * column, kSide * row);
      }
    }
    hits += here;
  });
  return hits;
}
