#include "isolux/render/shadows.h"

#include <algorithm>
#include <array>
#include <limits>

#include "isolux/base/parallel.h"
#include "isolux/render/crossings.h"
#include "isolux/render/fan_lanes.h"

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

void hide(std::uint32_t lanes, float (&share)[kLanes]) {
  for (; lanes != 0; lanes &= lanes - 1) share[std::countr_zero(lanes)] = 0;
}

// Half a tile's pixels, the lanes of a packet.
struct Half {
  std::size_t place;   // of its first pixel
  std::uint32_t hits;  // lanes

  PointPacket points(const Camera& camera, const SurfaceBuffer& buffer) const {
    PointPacket points;
    RayPacket rays;
    const auto [x0, y0] = buffer.pixel(place);
    aim_unit(camera.fan(), x0, y0, rays);
    for (std::uint32_t rest = hits; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      const SurfaceSample sample = buffer.sample(place + static_cast<std::size_t>(n));
      const Ray ray = rays.ray(n);
      points.position[n] = ray.at(sample.depth_mm);
      points.normal[n] = sample.normal();
      points.to_eye[n] = -ray.direction;
      points.came_mm[n] = sample.depth_mm;
      points.surface[n] = sample.surface;
      points.point[n] = sample.point;
    }
    return points;
  }
};

// Those that meet anything.
std::vector<Half> halves_of(const SurfaceBuffer& buffer) {
  std::vector<Half> halves;
  for (std::size_t tile = 0; tile < buffer.hits.size(); ++tile) {
    for (std::size_t half = 0; half < 2; ++half) {
      const auto hits = static_cast<std::uint32_t>(buffer.hits[tile] >> (32 * half));
      if (hits != 0) halves.push_back({64 * tile + 32 * half, hits});
    }
  }
  return halves;
}

RayTarget target_of(const Light& light) {
  if (light.kind == Light::Kind::kDirectional) return {normalize(light.place), true};
  return {light.place};
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

// What belongs to the rays of a packet to a light.
struct ShadowRays::Aim {
  std::uint32_t lanes;        // of the points that face the light
  double local_size[kLanes];  // in t
  double ends[kLanes];
};

ShadowRays::Aim ShadowRays::aim(const Light& light, const PointPacket& points, std::uint32_t wanted,
                                RayPacket& rays) const {
  Aim aim;
  aim.lanes = wanted;
  for (int n = 0; n < kLanes; ++n) {
    rays.set(n, {{}, {1, 0, 0}});
    if (!(wanted >> n & 1)) continue;
    const PreparedSurface& own = surfaces_.at(points.surface[n]);
    const double back = std::min(own.step_mm(), points.came_mm[n] / 2);
    const ToLight to = towards(light, points.position[n] + back * points.to_eye[n]);
    const double distance = length(to.ray.direction);
    if (!(dot(to.ray.direction, points.normal[n]) > -kFloatDoubt * distance)) {
      aim.lanes &= ~(1u << n);
      continue;
    }
    rays.set(n, to.ray);
    aim.ends[n] = to.end;
    aim.local_size[n] = std::min(own.local_size_mm(points.point[n]) / distance, to.end);
  }
  return aim;
}

bool ShadowRays::is_known(std::size_t surface) const {
  return surfaces_.all()[surface].tree() && scene_.surfaces[surface].material.opacity == 1;
}

void ShadowRays::set_packets(const Light& light, const PointPacket& points, std::uint32_t lanes,
                             std::int32_t number, ShadowPacket* packets) const {
  RayPacket rays{};
  const Aim aimed = aim(light, points, lanes, rays);
  for (int first = 0; first < kLanes; first += ShadowPacket::kCount) {
    ShadowPacket& packet = packets[first / ShadowPacket::kCount];
    packet.lanes = aimed.lanes >> first & 0xffff;
    for (int axis = 0; axis < 3; ++axis) {
      std::copy_n(rays.origin[axis] + first, ShadowPacket::kCount, packet.origin[axis]);
    }
    for (int n = 0; n < ShadowPacket::kCount; ++n) {
      const bool is_own = (packet.lanes >> n & 1) && points.surface[first + n] == number;
      packet.begin[n] = is_own ? static_cast<float>(aimed.local_size[first + n]) : 0;
      packet.own[n] = is_own ? points.point[first + n].triangle : ShadowPacket::kNone;
    }
  }
}

bool ShadowRays::tells_all(std::span<const KnownHits> known, float (&share)[kLanes]) const {
  if (known.empty()) return false;
  std::ranges::fill(share, 1.0f);
  for (std::size_t s = 0; s < known.size(); ++s) {
    if (!is_known(s) || known[s].near != 0) return false;
    hide(known[s].far, share);
  }
  return true;
}

void ShadowRays::reach(const Light& light, std::span<ShadowQuestion> questions) const {
  while (!questions.empty()) {
    const std::size_t count = std::min(IsoLanes::kPacketsAtOnce, questions.size());
    reach_few(light, questions.first(count));
    questions = questions.subspan(count);
  }
}

void ShadowRays::reach_few(const Light& light, std::span<ShadowQuestion> questions) const {
  constexpr std::size_t kMost = IsoLanes::kPacketsAtOnce;
  const std::size_t count = questions.size();
  std::array<RayPacket, kMost> rays;
  std::array<Aim, kMost> aims;
  std::array<std::uint32_t, kMost> lanes{}, near{}, far{};
  for (std::size_t p = 0; p < count; ++p) {
    std::ranges::fill(questions[p].share, 1.0f);
    rays[p] = {};
    aims[p] = aim(light, *questions[p].points, questions[p].lanes, rays[p]);
    lanes[p] = aims[p].lanes;
  }
  const std::span packets = std::span<const RayPacket>(rays).first(count);
  for (std::size_t s = 0; s < surfaces_.all().size(); ++s) {
    const PreparedSurface& surface = surfaces_.all()[s];
    const auto number = static_cast<std::int32_t>(s);
    const double opacity = scene_.surfaces[s].material.opacity;
    const auto is_known_to = [&](const ShadowQuestion& question) {
      return !question.known.empty() && is_known(s);
    };
    for (std::size_t p = 0; p < count; ++p) {
      near[p] = far[p] = 0;
      for (std::uint32_t rest = lanes[p]; rest != 0; rest &= rest - 1) {
        const int n = std::countr_zero(rest);
        const bool is_own = questions[p].points->surface[n] == number;
        rays[p].begin[n] = is_own ? static_cast<float>(aims[p].local_size[n]) : 0;
        rays[p].end[n] = static_cast<float>(aims[p].ends[n]);
        if (is_own) near[p] |= 1u << n;
        if (rays[p].begin[n] < rays[p].end[n]) far[p] |= 1u << n;
      }
      if (is_known_to(questions[p])) {
        hide(questions[p].known[s].far & lanes[p], questions[p].share);
        far[p] = 0;
      } else if (opacity < 1) {
        dim(surface, number, opacity, rays[p], far[p], questions[p].share);
        far[p] = 0;
      }
    }
    surface.any_hits(packets, std::span(far).first(count));
    auto asked = near;
    for (std::size_t p = 0; p < count; ++p) {
      hide(far[p], questions[p].share);
      for (std::uint32_t rest = near[p]; rest != 0; rest &= rest - 1) {
        const int n = std::countr_zero(rest);
        rays[p].end[n] = rays[p].begin[n];
        rays[p].begin[n] = 0;
        if (questions[p].share[n] == 0) near[p] &= ~(1u << n);
      }
      if (is_known_to(questions[p])) near[p] &= questions[p].known[s].near;
      asked[p] = is_known_to(questions[p]) ? 0 : near[p];
    }
    surface.any_hits(packets, std::span(asked).first(count));
    for (std::size_t p = 0; p < count; ++p) {
      ShadowQuestion& question = questions[p];
      if (!is_known_to(question)) near[p] = asked[p];
      for (std::uint32_t rest = near[p]; rest != 0; rest &= rest - 1) {
        const int n = std::countr_zero(rest);
        if (hides_itself(light, *question.points, n)) {
          question.share[n] *= static_cast<float>(1 - opacity);
        }
      }
      for (std::uint32_t rest = lanes[p]; rest != 0; rest &= rest - 1) {
        const int n = std::countr_zero(rest);
        if (question.share[n] == 0) lanes[p] &= ~(1u << n);
      }
    }
  }
}

void ShadowRays::dim(const PreparedSurface& surface, std::int32_t number, double opacity,
                     const RayPacket& rays, std::uint32_t lanes, float (&share)[kLanes]) {
  if (lanes == 0) return;
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

namespace {

// What opaque meshes hide from one light, [half][surface]; empty where there is no such mesh.
std::vector<KnownHits> find_known(const Scene& scene, const SceneSurfaces& surfaces,
                                  const ShadowRays& shadow_rays, const SurfaceBuffer& buffer,
                                  const std::vector<Half>& halves, const Light& light) {
  const std::size_t count = surfaces.all().size();
  std::vector<KnownHits> known;
  std::vector<ShadowPacket> packets;
  for (std::size_t s = 0; s < count; ++s) {
    if (!shadow_rays.is_known(s)) continue;
    known.resize(halves.size() * count);
    packets.resize(2 * halves.size());
    parallel_for(halves.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        shadow_rays.set_packets(light, halves[n].points(*scene.camera, buffer), halves[n].hits,
                                static_cast<std::int32_t>(s), &packets[2 * n]);
      }
    });
    surfaces.all()[s].tree()->find_shadows(target_of(light), packets);
    for (std::size_t n = 0; n < halves.size(); ++n) {
      const ShadowPacket &low = packets[2 * n], &high = packets[2 * n + 1];
      known[n * count + s] = {low.far | high.far << 16, low.near | high.near << 16};
    }
  }
  return known;
}

}  // namespace

void cast_shadows(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceBuffer& buffer,
                  Shadows& shadows, const ProgressListener& listener) {
  if (!scene.shadows) {
    shadows = {};
    return;
  }
  const std::size_t lights = scene.lights.size();
  shadows.pixels.resize(lights);
  for (auto& of_light : shadows.pixels) of_light.resize(buffer.pixels());
  shadows.further.resize(buffer.further.size());
  const ShadowRays shadow_rays(scene, surfaces);
  const std::vector<Half> halves = halves_of(buffer);
  std::vector<std::vector<KnownHits>> known;  // [light]
  for (const Light& light : scene.lights) {
    known.push_back(find_known(scene, surfaces, shadow_rays, buffer, halves, light));
  }
  // Of half tiles side by side, as many as go together.
  const auto cast_halves = [&](std::size_t begin, std::size_t end) {
    std::array<PointPacket, IsoLanes::kPacketsAtOnce> points;
    std::array<ShadowQuestion, IsoLanes::kPacketsAtOnce> questions;
    for (std::size_t l = 0; l < lights; ++l) {
      std::size_t count = 0;
      std::array<std::size_t, IsoLanes::kPacketsAtOnce> asking;
      const auto answer = [&](std::size_t n, const float(&share)[kLanes]) {
        std::ranges::copy(share, shadows.pixels[l].data() + halves[n].place);
      };
      for (std::size_t n = begin; n < end; ++n) {
        float share[kLanes];
        const std::size_t surfaces_known = known[l].empty() ? 0 : surfaces.all().size();
        const auto of_half = std::span(known[l]).subspan(n * surfaces_known, surfaces_known);
        if (shadow_rays.tells_all(of_half, share)) {
          answer(n, share);
          continue;
        }
        points[count] = halves[n].points(*scene.camera, buffer);
        questions[count] = {&points[count], halves[n].hits, of_half, {}};
        asking[count++] = n;
      }
      shadow_rays.reach(scene.lights[l], std::span(questions).first(count));
      for (std::size_t q = 0; q < count; ++q) answer(asking[q], questions[q].share);
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
        ShadowQuestion question{&points, lanes, {}, {}};
        shadow_rays.reach(scene.lights[l], {&question, 1});
        std::copy_n(question.share, count, to.data() + l * further.size() + first);
      }
    }
  };
  constexpr std::size_t kTilesAPiece = 32;
  Progress progress(listener, "casting shadows", halves.size() + buffer.further.size());
  parallel_for(halves.size(), IsoLanes::kPacketsAtOnce, [&](std::size_t begin, std::size_t end) {
    cast_halves(begin, end);
    progress.advance(end - begin);
  });
  parallel_for(buffer.further.size(), kTilesAPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tile = begin; tile < end; ++tile) cast_further(tile);
    progress.advance(end - begin);
  });
}

}  // namespace isolux
