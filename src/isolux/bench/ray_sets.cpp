#include "isolux/bench/ray_sets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>

#include "isolux/base/error.h"
#include "isolux/base/exact_math.h"
#include "isolux/base/output_file.h"

namespace isolux {
namespace {

constexpr double kLift = 0.5;  // mm
constexpr int kBlock = 4;      // pixels

using StoredRay = std::array<float, 6>;

// A number in [0, 1) from a counter: the finalizer of splitmix64 (Steele, Lea and Flood 2014, Fast
// splittable pseudorandom number generators).
double hashed_unit(std::uint64_t counter) {
  std::uint64_t bits = counter * 0x9e3779b97f4a7c15;
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111eb;
  return static_cast<double>((bits ^ (bits >> 31)) >> 11) * 0x1p-53;
}

Vec3 point_on_sphere(double u, double v) {
  const double z = 2 * u - 1, radius = std::sqrt(1 - z * z), angle = 2 * exact::kPi * v;
  return {radius * exact::cos(angle), radius * exact::sin(angle), z};
}

using DirectionAt = std::function<Vec3(std::size_t pixel, Vec3 origin, Vec3 normal)>;

std::vector<Ray> rays_from_hits(const Camera& camera, const SurfaceBuffer& buffer,
                                const DirectionAt& direction_at) {
  std::vector<Ray> rays;
  const auto add = [&](int x, int y) {
    const std::size_t pixel = buffer.at(x, y);
    const SurfaceSample sample = buffer.sample(pixel);
    if (!sample.is_hit()) return;
    const Vec3 origin = camera.ray(x, y).at(sample.depth_mm) + kLift * sample.normal();
    rays.push_back({origin, direction_at(pixel, origin, sample.normal())});
  };
  for (int y0 = 0; y0 < buffer.height(); y0 += kBlock) {
    for (int x0 = 0; x0 < buffer.width(); x0 += kBlock) {
      for (int y = y0; y < std::min(y0 + kBlock, buffer.height()); ++y) {
        for (int x = x0; x < std::min(x0 + kBlock, buffer.width()); ++x) add(x, y);
      }
    }
  }
  return rays;
}

}  // namespace

std::vector<Ray> cosine_rays(const Camera& camera, const SurfaceBuffer& buffer) {
  return rays_from_hits(camera, buffer, [](std::size_t pixel, Vec3, Vec3 normal) {
    // A unit sphere that touches the surface, seen from the point of touch, has this density.
    const Vec3 on_sphere = point_on_sphere(hashed_unit(2 * pixel), hashed_unit(2 * pixel + 1));
    return normalize(normal + 0.999999 * on_sphere);
  });
}

std::vector<Ray> shadow_rays(const Camera& camera, const SurfaceBuffer& buffer, Vec3 lamp) {
  return rays_from_hits(camera, buffer,
                        [&](std::size_t, Vec3 origin, Vec3) { return normalize(lamp - origin); });
}

void write_rays(const std::string& path, const std::vector<Ray>& rays) {
  std::vector<StoredRay> stored;
  stored.reserve(rays.size());
  for (const auto& [o, d] : rays) {
    stored.push_back({static_cast<float>(o.x), static_cast<float>(o.y), static_cast<float>(o.z),
                      static_cast<float>(d.x), static_cast<float>(d.y), static_cast<float>(d.z)});
  }
  write_whole_file(
      path, {reinterpret_cast<const char*>(stored.data()), stored.size() * sizeof(StoredRay)});
}

std::vector<Ray> read_rays(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<Ray> rays;
  for (StoredRay r{}; file.read(reinterpret_cast<char*>(r.data()), sizeof r);) {
    rays.push_back({{r[0], r[1], r[2]}, {r[3], r[4], r[5]}});
  }
  if (!file.eof()) throw WorkError(path, "cannot be read", "check its name");
  return rays;
}

}  // namespace isolux
