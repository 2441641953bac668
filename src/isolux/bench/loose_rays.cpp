#include "isolux/bench/loose_rays.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <limits>
#include <span>

#include "isolux/base/mat3.h"
#include "isolux/base/parallel.h"

namespace isolux {
namespace {

constexpr std::size_t kCount = RayLanes::kCount;

constexpr std::size_t kPacketsAtOnce = IsoLanes::kPacketsAtOnce;

// How many rays are left of the lanes in use by met_of(rays in lanes, lanes in use).
template <typename MetOf>
std::size_t count_met(const std::vector<Ray>& rays, const std::optional<Affine>& surface_from_world,
                      const MetOf& met_of) {
  const auto set = [&](RayLanes& lanes, std::size_t first, std::size_t count) {
    for (std::size_t n = 0; n < kCount; ++n) {
      Ray ray = rays[first + std::min(n, count - 1)];
      if (surface_from_world) {
        ray.origin = surface_from_world->point(ray.origin);
        ray.direction = surface_from_world->vector(ray.direction);
      }
      for (int axis = 0; axis < 3; ++axis) {
        lanes.origin[axis][n] = ray.origin[axis];
        lanes.direction[axis][n] = ray.direction[axis];
      }
      lanes.begin[n] = 0;
      lanes.end[n] = std::numeric_limits<float>::infinity();
    }
  };
  std::atomic<std::size_t> met{0};
  parallel_for(
      (rays.size() + kCount - 1) / kCount, kPacketsAtOnce, [&](std::size_t begin, std::size_t end) {
        std::array<RayLanes, kPacketsAtOnce> packets;
        std::array<std::uint32_t, kPacketsAtOnce> lanes;
        for (std::size_t p = begin; p < end; ++p) {
          const std::size_t count = std::min(kCount, rays.size() - kCount * p);
          set(packets[p - begin], kCount * p, count);
          lanes[p - begin] = ~std::uint32_t{0} >> (kCount - count);
        }
        const std::size_t count = end - begin;
        met_of(std::span<const RayLanes>(packets.data(), count), std::span(lanes.data(), count));
        std::size_t here = 0;
        for (std::size_t p = 0; p < count; ++p) {
          here += static_cast<std::size_t>(std::popcount(lanes[p]));
        }
        met += here;
      });
  return met;
}

}  // namespace

LooseRays::LooseRays(const SurfaceItem& surface) {
  if (surface.mesh) {
    tree_.emplace(surface.mesh);
    return;
  }
  surface_from_world_ = inverse(surface.volume->world_from_index);
  const auto bricks = std::make_shared<const BrickGrid>(*surface.volume);
  lanes_.emplace(IsoSurface(surface.volume, bricks, surface.iso), *bricks);
}

std::size_t LooseRays::count_hits(const std::vector<Ray>& rays,
                                  const std::optional<Vec3>& lamp) const {
  if (lamp && tree_) return count_hidden(rays, *lamp);
  return count_met(rays, surface_from_world_,
                   [&](std::span<const RayLanes> packets, std::span<std::uint32_t> lanes) {
                     if (lamp) return lanes_->occluded(packets, lanes);
                     if (tree_) {
                       for (std::size_t p = 0; p < packets.size(); ++p) {
                         MeshHitLanes hits;
                         tree_->first_hits(packets[p], lanes[p], hits);
                         lanes[p] &= hits.hit;
                       }
                       return;
                     }
                     std::array<HitLanes, kPacketsAtOnce> hits;
                     lanes_->first_hits(packets, lanes, std::span(hits).first(packets.size()));
                     for (std::size_t p = 0; p < packets.size(); ++p) lanes[p] = hits[p].hit;
                   });
}

std::size_t LooseRays::count_hidden(const std::vector<Ray>& rays, Vec3 lamp) const {
  constexpr std::size_t kLanes = ShadowPacket::kCount;
  std::vector<ShadowPacket> packets((rays.size() + kLanes - 1) / kLanes);
  parallel_for(packets.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      ShadowPacket& packet = packets[p];
      const std::size_t count = std::min(kLanes, rays.size() - kLanes * p);
      packet.lanes = (1u << count) - 1;
      for (std::size_t n = 0; n < kLanes; ++n) {
        const Vec3& origin = rays[kLanes * p + std::min(n, count - 1)].origin;
        for (int axis = 0; axis < 3; ++axis) packet.origin[axis][n] = origin[axis];
        packet.begin[n] = 0;
        packet.own[n] = ShadowPacket::kNone;
      }
    }
  });
  tree_->find_shadows({lamp}, packets);
  std::size_t hidden = 0;
  for (const ShadowPacket& packet : packets) {
    hidden += static_cast<std::size_t>(std::popcount(packet.far));
  }
  return hidden;
}

}  // namespace isolux
