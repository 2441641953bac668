#include "isolux/render/shadows.h"

#include <algorithm>
#include <limits>

#include "isolux/base/parallel.h"
#include "isolux/render/crossings.h"

namespace isolux {
namespace {

constexpr int kLanes = PointPacket::kCount;
// How far n . l may lie below 0 and be above it in the floats of lighting.
constexpr double kFloatDoubt = 1e-5;

struct ToLight {
  Ray ray;  // from a point that lies a little before the surface
  double end;
};

ToLight towards(const Light& light, Vec3 start) {
  if (light.kind == Light::Kind::kDirectional) {
    return {{start, normalize(light.place)}, std::numeric_limits<double>::infinity()};
  }
  return {{start, light.place - start}, 1};
}

void set_point(const FurtherPoint& from, int n, PointPacket& to) {
  for (int axis = 0; axis < 3; ++axis) {
    to.normal[n][axis] = from.normal[axis];
    to.to_eye[n][axis] = from.to_eye[axis];
  }
  to.position[n] = from.position;
  to.came_mm[n] = from.came_mm;
  to.surface[n] = from.surface;
  to.point[n] = from.point;
}

}  // namespace

std::vector<float> Shadows::of_pixel(std::size_t place) const {
  std::vector<float> shares;
  for (const auto& of_light : pixels) shares.push_back(of_light[place]);
  return shares;
}

std::vector<float> Shadows::of_further(std::size_t tile, std::size_t point) const {
  std::vector<float> shares;
  const std::size_t points = empty() ? 0 : further[tile].size() / pixels.size();
  for (std::size_t l = 0; l < pixels.size(); ++l) {
    shares.push_back(further[tile][l * points + point]);
  }
  return shares;
}

ShadowRays::ShadowRays(const Scene& scene, const SceneSurfaces& surfaces)
    : scene_(scene), surfaces_(surfaces) {}

void ShadowRays::reach(const Light& light, const PointPacket& points, std::uint32_t lanes,
                       float (&share)[kLanes]) const {
  RayPacket rays{};
  double local_size[kLanes];  // in t
  double end[kLanes];
  for (int n = 0; n < kLanes; ++n) {
    share[n] = 1;
    rays.set(n, {{}, {1, 0, 0}});
    if (!(lanes >> n & 1)) continue;
    const PreparedSurface& own = surfaces_.at(points.surface[n]);
    const double back = std::min(own.step_mm(), points.came_mm[n] / 2);
    const ToLight to = towards(light, points.position[n] + back * points.to_eye[n]);
    const double distance = length(to.ray.direction);
    if (!(dot(to.ray.direction, points.normal[n]) > -kFloatDoubt * distance)) {
      lanes &= ~(1u << n);
      continue;
    }
    rays.set(n, to.ray);
    end[n] = to.end;
    local_size[n] = std::min(own.local_size_mm(points.point[n]) / distance, end[n]);
  }
  for (std::size_t s = 0; s < surfaces_.all().size() && lanes != 0; ++s) {
    const auto number = static_cast<std::int32_t>(s);
    std::uint32_t near = 0, far = 0;
    for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      const bool is_own = points.surface[n] == number;
      rays.begin[n] = is_own ? static_cast<float>(local_size[n]) : 0;
      rays.end[n] = static_cast<float>(end[n]);
      if (is_own) near |= 1u << n;
      if (rays.begin[n] < rays.end[n]) far |= 1u << n;
    }
    const double opacity = scene_.surfaces[s].material.opacity;
    dim(surfaces_.all()[s], number, opacity, rays, far, share);
    for (std::uint32_t rest = near; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      rays.end[n] = rays.begin[n];
      rays.begin[n] = 0;
      if (share[n] == 0) near &= ~(1u << n);
    }
    if (near != 0) near = surfaces_.all()[s].any_hits(rays, near);
    for (std::uint32_t rest = near; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      if (hides_itself(light, points, n)) share[n] *= static_cast<float>(1 - opacity);
    }
    for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      if (share[n] == 0) lanes &= ~(1u << n);
    }
  }
}

void ShadowRays::dim(const PreparedSurface& surface, std::int32_t number, double opacity,
                     const RayPacket& rays, std::uint32_t lanes, float (&share)[kLanes]) {
  if (lanes == 0) return;
  if (opacity == 1) {
    for (std::uint32_t rest = surface.any_hits(rays, lanes); rest != 0; rest &= rest - 1) {
      share[std::countr_zero(rest)] = 0;
    }
    return;
  }
  Crossings crossings(surface, number, rays);
  double from[kLanes];
  std::ranges::copy(rays.begin, from);
  crossings.find(lanes, from);
  for (std::uint32_t hit = lanes & crossings.hits().hit; hit != 0;) {
    for (std::uint32_t rest = hit; rest != 0; rest &= rest - 1) {
      float& of_lane = share[std::countr_zero(rest)];
      of_lane *= static_cast<float>(1 - opacity);
      if (of_lane < kLeastShare) of_lane = 0;
      if (of_lane == 0) hit &= ~(rest & -rest);
    }
    crossings.pass(hit);
    hit &= crossings.hits().hit;
  }
}

bool ShadowRays::hides_itself(const Light& light, const PointPacket& points, int n) const {
  const PreparedSurface& own = surfaces_.at(points.surface[n]);
  const Vec3 position = points.position[n], to_eye = points.to_eye[n];
  const Ray came{position + points.came_mm[n] * to_eye, -to_eye};
  const Vec3 start = came.at(own.t_before(came, points.came_mm[n]));
  const ToLight to = towards(light, start);
  if (const auto normal = own.true_normal(position, points.point[n])) {
    const double side = dot(*normal, to_eye) < 0 ? -1 : 1;
    if (side * dot(*normal, to.ray.direction) < 0) return false;
  }
  const double local_size = own.local_size_mm(points.point[n]) / length(to.ray.direction);
  return own.any_hit(to.ray, std::min(local_size, to.end));
}

void cast_shadows(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceBuffer& buffer,
                  Shadows& shadows, const ProgressListener& listener) {
  if (!scene.shadows) {
    shadows = {};
    return;
  }
  const std::size_t lights = scene.lights.size(), tiles = buffer.hits.size();
  shadows.pixels.resize(lights);
  for (auto& of_light : shadows.pixels) of_light.resize(buffer.pixels());
  shadows.further.resize(buffer.further.size());
  const ShadowRays shadow_rays(scene, surfaces);
  const auto cast_half = [&](std::size_t tile, std::size_t half) {
    const auto hits = static_cast<std::uint32_t>(buffer.hits[tile] >> (32 * half));
    if (hits == 0) return;
    PointPacket points;
    for (std::uint32_t rest = hits; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      const std::size_t place = 64 * tile + 32 * half + static_cast<std::size_t>(n);
      const auto [x, y] = buffer.pixel(place);
      const SurfaceSample sample = buffer.sample(place);
      const Ray ray = scene.camera->ray(x, y);
      points.position[n] = ray.at(sample.depth_mm);
      points.normal[n] = sample.normal();
      points.to_eye[n] = -ray.direction;
      points.came_mm[n] = sample.depth_mm;
      points.surface[n] = sample.surface;
      points.point[n] = sample.point;
    }
    for (std::size_t l = 0; l < lights; ++l) {
      float share[kLanes];
      shadow_rays.reach(scene.lights[l], points, hits, share);
      std::ranges::copy(share, shadows.pixels[l].data() + 64 * tile + 32 * half);
    }
  };
  const auto cast_further = [&](std::size_t tile) {
    const FurtherPoints& further = buffer.further[tile];
    std::vector<float>& to = shadows.further[tile];
    to.assign(lights * further.size(), 1);
    for (std::size_t first = 0; first < further.size(); first += kLanes) {
      const std::size_t count = std::min<std::size_t>(kLanes, further.size() - first);
      PointPacket points;
      std::uint32_t lanes = 0;
      for (std::size_t n = 0; n < count; ++n) {
        if (further[first + n].surface == FurtherPoint::kBackground) continue;
        set_point(further[first + n], static_cast<int>(n), points);
        lanes |= 1u << n;
      }
      for (std::size_t l = 0; l < lights && lanes != 0; ++l) {
        float share[kLanes];
        shadow_rays.reach(scene.lights[l], points, lanes, share);
        std::copy_n(share, count, to.data() + l * further.size() + first);
      }
    }
  };
  constexpr std::size_t kTilesAPiece = 32;
  Progress progress(listener, "casting shadows", tiles);
  parallel_for(tiles, kTilesAPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tile = begin; tile < end; ++tile) {
      cast_half(tile, 0);
      cast_half(tile, 1);
      if (!buffer.further.empty()) cast_further(tile);
    }
    progress.advance(end - begin);
  });
}

}  // namespace isolux
