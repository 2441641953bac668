#include "isolux/render/first_bounce.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "isolux/render/cosine_direction.h"
#include "isolux/render/lighting.h"
#include "isolux/render/shadows.h"
#include "isolux/shade/reflection.h"

namespace isolux {
namespace {

constexpr int kLanes = RayPacket::kCount;
constexpr std::uint32_t kRays = 2048;
constexpr std::uint32_t kSeed = 0xf125;
constexpr std::size_t kMostSenders = 8;
constexpr double kReach = 0.2;         // of a sender, in its distance
constexpr double kLeastWeight = 1e-3;  // of what is seen through translucent surfaces
// Off a surface, in its own steps: far enough for the floats of lanes to see the right side.
constexpr double kOff = 10;

double mean(Rgb c) { return (c.r + c.g + c.b) / 3; }

// What a ray has met, and the light that comes from there.
struct Met {
  Vec3 position;
  std::int32_t surface;
  double light;
};

class Look {
 public:
  Look(const Scene& scene, const SceneSurfaces& surfaces)
      : scene_(scene), surfaces_(surfaces), shadows_(scene, surfaces) {}

  // Rays side by side, through translucent surfaces and on.
  void along(RayPacket& rays) {
    double weight[kLanes];
    std::ranges::fill(weight, 1.0);
    for (std::uint32_t going = ~0u; going != 0;) {
      PacketHits hits;
      for (std::size_t s = 0; s < surfaces_.all().size(); ++s) {
        surfaces_.all()[s].first_hits(rays, going, static_cast<std::int32_t>(s), hits);
      }
      see_sky(going & ~hits.hit, weight);
      going &= hits.hit;
      add(rays, hits, going, weight);
      going = pass(rays, hits, going, weight);
    }
  }

  const std::vector<Met>& met() const { return met_; }
  double sky() const { return sky_; }

 private:
  const SurfaceItem& item(std::int32_t number) const {
    return scene_.surfaces[static_cast<std::size_t>(number)];
  }

  void see_sky(std::uint32_t lanes, const double (&weight)[kLanes]) {
    if (scene_.has_default_ambient) return;
    for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
      sky_ += weight[std::countr_zero(rest)] * mean(scene_.ambient);
    }
  }

  void add(const RayPacket& rays, PacketHits& hits, std::uint32_t lanes,
           const double (&weight)[kLanes]) {
    PointPacket points;
    for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      const Ray ray = rays.ray(n);
      hits.face(n, ray.direction);
      points.position[n] = ray.at(hits.t[n]);
      points.normal[n] = {hits.normal[0][n], hits.normal[1][n], hits.normal[2][n]};
      points.to_eye[n] = -ray.direction;
      points.came_mm[n] = hits.t[n];
      points.surface[n] = hits.surface[n];
      points.point[n] = hits.point[n];
    }
    Rgb arriving[kLanes];
    for (const Light& lamp : scene_.lights) {
      ShadowQuestion question{&points, lanes, {}, {}};
      std::ranges::fill(question.share, 1.0f);
      if (scene_.shadows && lanes != 0) shadows_.reach(lamp, {&question, 1});
      for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
        const int n = std::countr_zero(rest);
        arriving[n] = arriving[n] + static_cast<double>(question.share[n]) *
                                        irradiance(lamp, {points.position[n], points.normal[n],
                                                          points.to_eye[n]});
      }
    }
    for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      const Material material = material_at(item(hits.surface[n]), hits.point[n]);
      const double light = weight[n] * material.opacity * mean(material.kd * arriving[n]);
      if (light > 0) met_.push_back({points.position[n], hits.surface[n], light});
    }
  }

  // The lanes that go on behind what they have met.
  std::uint32_t pass(RayPacket& rays, const PacketHits& hits, std::uint32_t lanes,
                     double (&weight)[kLanes]) const {
    std::uint32_t onward = 0;
    for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      weight[n] *= 1 - item(hits.surface[n]).material.opacity;
      if (weight[n] < kLeastWeight) continue;
      Ray ray = rays.ray(n);
      ray.origin = ray.at(hits.t[n] + kOff * surfaces_.at(hits.surface[n]).step_mm());
      rays.set(n, ray);
      onward |= 1u << n;
    }
    return onward;
  }

  const Scene& scene_;
  const SceneSurfaces& surfaces_;
  ShadowRays shadows_;
  std::vector<Met> met_;
  double sky_ = 0;
};

// Takes the places that send most, one after another, each with what lies about it.
std::vector<Sender> brightest(std::vector<Met> met, Vec3 point, double all) {
  std::vector<Sender> senders;
  while (!met.empty() && senders.size() < kMostSenders) {
    const auto is_about = [&](const Met& one, const Met& middle) {
      return length(one.position - middle.position) <= kReach * length(middle.position - point);
    };
    const Met* best = nullptr;
    double most = 0;
    for (const Met& middle : met) {
      double sum = 0;
      for (const Met& one : met) sum += is_about(one, middle) ? one.light : 0;
      if (sum <= most) continue;
      most = sum;
      best = &middle;
    }
    const Met middle = *best;
    senders.push_back({middle.position, middle.surface, most / all});
    std::erase_if(met, [&](const Met& one) { return is_about(one, middle); });
  }
  return senders;
}

}  // namespace

FirstBounce first_bounce(const Scene& scene, const SceneSurfaces& surfaces,
                         const SurfaceBuffer& buffer, std::size_t place) {
  const SurfaceSample sample = buffer.sample(place);
  const auto [x, y] = buffer.pixel(place);
  const SurfacePoint point = point_of(scene.camera->ray(x, y), sample);
  const PreparedSurface& own = surfaces.at(sample.surface);
  const Vec3 up = own.true_normal(point.position, sample.point).value_or(point.to_eye);
  const Vec3 above = dot(up, point.to_eye) < 0 ? -up : up;
  const Vec3 start = point.position + kOff * own.step_mm() * above;

  Look look(scene, surfaces);
  for (std::uint32_t first = 0; first < kRays; first += kLanes) {
    RayPacket rays{};
    std::ranges::fill(rays.end, std::numeric_limits<float>::infinity());
    for (int n = 0; n < kLanes; ++n) {
      const UnitPoint drawn = sobol_point(first + static_cast<std::uint32_t>(n), kSeed);
      rays.set(n, {start, kept_above(cosine_direction(point.normal, drawn), above)});
    }
    look.along(rays);
  }
  double all = look.sky();
  for (const Met& one : look.met()) all += one.light;
  if (all == 0) return {};
  return {all / kRays, brightest(look.met(), point.position, all), look.sky() / all};
}

}  // namespace isolux
