#include "isolux/bench/loose_rays.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>

#include "isolux/base/mat3.h"
#include "isolux/base/parallel.h"

namespace isolux {
namespace {

constexpr std::size_t kCount = RayLanes::kCount;

// How many rays have their bit in what met_of(rays in lanes, lanes in use) answers.
template <typename MetOf>
std::size_t count_met(const std::vector<Ray>& rays, const std::optional<Affine>& surface_from_world,
                      const MetOf& met_of) {
  const auto count_of = [&](std::size_t first) {
    const std::size_t count = std::min(kCount, rays.size() - first);
    RayLanes lanes;
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
    const std::uint32_t wanted = ~std::uint32_t{0} >> (kCount - count);
    return static_cast<std::size_t>(std::popcount(met_of(lanes, wanted) & wanted));
  };
  std::atomic<std::size_t> met{0};
  parallel_for((rays.size() + kCount - 1) / kCount, 256, [&](std::size_t begin, std::size_t end) {
    std::size_t here = 0;
    for (std::size_t packet = begin; packet < end; ++packet) here += count_of(kCount * packet);
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
  return count_met(rays, surface_from_world_, [&](const RayLanes& lanes, std::uint32_t wanted) {
    if (lamp) return lanes_->occluded(lanes, wanted);
    if (tree_) {
      MeshHitLanes hits;
      tree_->first_hits(lanes, wanted, hits);
      return hits.hit;
    }
    HitLanes hits;
    lanes_->first_hits(lanes, wanted, hits);
    return hits.hit;
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
