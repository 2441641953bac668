#include "isolux/render/link_tracer.h"

#include <bit>

#include "isolux/base/sobol.h"

namespace isolux {

LinkTracer::LinkTracer(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceSamples& to)
    : surfaces_(surfaces), to_(to) {
  for (const SurfaceItem& item : scene.surfaces) opacities_.push_back(item.material.opacity);
}

void LinkTracer::trace(LinkRays& rays) const {
  constexpr int kLanes = LinkRays::kCount;
  constexpr std::uint32_t kSeed = 0x11486;
  for (int n = 0; n < kLanes; ++n) {
    rays.packet.begin[n] = 0;
    rays.packet.end[n] = rays.reach_mm[n];
    if (n >= rays.count) rays.packet.set(n, rays.packet.ray(0));
    rays.distance_mm[n] = 0;
  }
  std::uint32_t going = ~0u >> (kLanes - rays.count);
  for (std::uint32_t passed = 0; going != 0; ++passed) {
    PacketHits hits;
    for (std::size_t s = 0; s < surfaces_.all().size(); ++s) {
      surfaces_.all()[s].first_hits(rays.packet, going, static_cast<std::int32_t>(s), hits);
    }
    for (std::uint32_t rest = going; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      going &= ~(1u << n);
      rays.to[n] = LinkRays::kSky;
      if (!(hits.hit >> n & 1)) continue;
      const double opacity = opacities_[static_cast<std::size_t>(hits.surface[n])];
      if (opacity < 1) {
        const std::uint32_t seed = mixed(mixed(kSeed, rays.seed[n]), passed);
        if (sobol_point(rays.number[n], seed).u >= opacity) {
          Ray ray = rays.packet.ray(n);
          const double gone = hits.t[n] + kOff * surfaces_.at(hits.surface[n]).step_mm();
          ray.origin = ray.at(gone);
          rays.packet.set(n, ray);
          rays.packet.end[n] -= static_cast<float>(gone);
          rays.distance_mm[n] += gone;
          going |= 1u << n;
          continue;
        }
      }
      rays.distance_mm[n] += hits.t[n];
      rays.to[n] = met(rays, hits, n, passed > 0);
    }
  }
}

// The sample that stands for what ray n has met.
std::uint32_t LinkTracer::met(const LinkRays& rays, PacketHits& hits, int n,
                              bool has_passed) const {
  const Ray ray = rays.packet.ray(n);
  hits.face(n, ray.direction);
  const Vec3 normal{hits.normal[0][n], hits.normal[1][n], hits.normal[2][n]};
  const bool turned = (hits.turned >> n & 1) != 0;
  const Vec3 position = ray.at(hits.t[n]);
  const Vec3 outward = turned ? -normal : normal;
  const PreparedSurface& surface = surfaces_.at(hits.surface[n]);
  // The isosurface that a ray has left, it meets from the side that it left.
  const bool stays = !has_passed && surface.lanes() && hits.surface[n] == rays.surface[n];
  SeenSide side;
  side.inside =
      stays ? rays.inside[n] : is_inside(surface, position, hits.point[n], outward, ray.direction);
  side.flipped = turned != side.inside;
  const std::uint32_t found = to_.find(hits.surface[n], position, hits.point[n], outward, side);
  return found == SurfaceSamples::kNone ? LinkRays::kDark : found;
}

}  // namespace isolux
