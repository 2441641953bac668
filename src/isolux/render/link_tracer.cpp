#include "isolux/render/link_tracer.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <span>

#include "isolux/base/sobol.h"

namespace isolux {

LinkTracer::LinkTracer(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceSamples& to)
    : surfaces_(surfaces), to_(to) {
  for (const SurfaceItem& item : scene.surfaces) opacities_.push_back(item.material.opacity);
}

void LinkTracer::trace(LinkRays& rays) const {
  constexpr int kLanes = LinkRays::kLanes;
  const int packets = (rays.count + kLanes - 1) / kLanes;
  std::array<std::uint32_t, LinkRays::kPackets> going{};
  for (int n = 0; n < packets * kLanes; ++n) {
    RayPacket& packet = rays.packets[LinkRays::packet_of(n)];
    packet.begin[n % kLanes] = 0;
    packet.end[n % kLanes] = rays.reach_mm[n];
    rays.distance_mm[n] = 0;
    if (n < rays.count) {
      going[LinkRays::packet_of(n)] |= 1u << n % kLanes;
    } else {
      rays.set(n, rays.ray(0));
    }
  }
  const auto count = static_cast<std::size_t>(packets);
  const auto rays_in = std::span<const RayPacket>(rays.packets).first(count);
  const auto lanes = std::span(going).first(count);
  for (std::uint32_t passed = 0; std::ranges::any_of(lanes, std::identity()); ++passed) {
    std::array<PacketHits, LinkRays::kPackets> hits;
    for (std::size_t s = 0; s < surfaces_.all().size(); ++s) {
      surfaces_.all()[s].first_hits(rays_in, lanes, static_cast<std::int32_t>(s),
                                    std::span(hits).first(count));
    }
    for (std::size_t p = 0; p < count; ++p) {
      for (std::uint32_t rest = lanes[p]; rest != 0; rest &= rest - 1) {
        const int lane = std::countr_zero(rest), n = static_cast<int>(p) * kLanes + lane;
        rays.to[n] = LinkRays::kSky;
        if ((hits[p].hit >> lane & 1) && passes(rays, hits[p], n, passed)) continue;
        lanes[p] &= ~(1u << lane);
        if (!(hits[p].hit >> lane & 1)) continue;
        rays.distance_mm[n] += hits[p].t[lane];
        rays.to[n] = met(rays, hits[p], n, passed > 0);
      }
    }
  }
}

// Whether ray n goes through what it has met; then it goes on from there.
bool LinkTracer::passes(LinkRays& rays, const PacketHits& hits, int n, std::uint32_t passed) const {
  constexpr std::uint32_t kSeed = 0x11486;
  const int lane = n % LinkRays::kLanes;
  const double opacity = opacities_[static_cast<std::size_t>(hits.surface[lane])];
  if (opacity == 1) return false;
  const std::uint32_t seed = mixed(mixed(kSeed, rays.seed[n]), passed);
  if (sobol_point(rays.number[n], seed).u < opacity) return false;
  Ray ray = rays.ray(n);
  const double gone = hits.t[lane] + kOff * surfaces_.at(hits.surface[lane]).step_mm();
  ray.origin = ray.at(gone);
  rays.set(n, ray);
  rays.packets[LinkRays::packet_of(n)].end[lane] -= static_cast<float>(gone);
  rays.distance_mm[n] += gone;
  return true;
}

// The sample that stands for what ray n has met.
std::uint32_t LinkTracer::met(const LinkRays& rays, PacketHits& hits, int n,
                              bool has_passed) const {
  const Ray ray = rays.ray(n);
  const int lane = n % LinkRays::kLanes;
  hits.face(lane, ray.direction);
  const Vec3 normal{hits.normal[0][lane], hits.normal[1][lane], hits.normal[2][lane]};
  const bool turned = (hits.turned >> lane & 1) != 0;
  const Vec3 position = ray.at(hits.t[lane]);
  const Vec3 outward = turned ? -normal : normal;
  const PreparedSurface& surface = surfaces_.at(hits.surface[lane]);
  // The isosurface that a ray has left, it meets from the side that it left.
  const bool stays = !has_passed && surface.lanes() && hits.surface[lane] == rays.surface[n];
  SeenSide side;
  side.inside = stays ? rays.inside[n]
                      : is_inside(surface, position, hits.point[lane], outward, ray.direction);
  side.flipped = turned != side.inside;
  const std::uint32_t found =
      to_.find(hits.surface[lane], position, hits.point[lane], outward, side);
  return found == SurfaceSamples::kNone ? LinkRays::kDark : found;
}

}  // namespace isolux
