#include "isolux/bench/loose_rays.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

constexpr std::size_t kCount = RayLanes::kCount;

IsoLanes lanes_of(const SurfaceItem& item) {
  const auto bricks = std::make_shared<const BrickGrid>(*item.volume);
  return {IsoSurface(item.volume, bricks, item.iso), *bricks};
}

}  // namespace

LooseRays::LooseRays(const SurfaceItem& surface)
    : index_from_world_(inverse(surface.volume->world_from_index)), lanes_(lanes_of(surface)) {}

std::size_t LooseRays::count_hits(const std::vector<Ray>& rays, RayQuery query) const {
  const auto hits_of = [&](std::size_t first) -> int {
    const std::size_t count = std::min(kCount, rays.size() - first);
    RayLanes lanes;
    for (std::size_t n = 0; n < kCount; ++n) {
      const Ray& ray = rays[first + std::min(n, count - 1)];
      const Vec3 origin = index_from_world_.point(ray.origin);
      const Vec3 direction = index_from_world_.vector(ray.direction);
      for (int axis = 0; axis < 3; ++axis) {
        lanes.origin[axis][n] = origin[axis];
        lanes.direction[axis][n] = direction[axis];
      }
      lanes.begin[n] = 0;
      lanes.end[n] = std::numeric_limits<float>::infinity();
    }
    const std::uint32_t wanted = ~std::uint32_t{0} >> (kCount - count);
    if (query == RayQuery::kAny) return std::popcount(lanes_.occluded(lanes, wanted));
    HitLanes hits;
    lanes_.first_hits(lanes, wanted, hits);
    return std::popcount(hits.hit);
  };
  std::atomic<std::size_t> hits{0};
  parallel_for((rays.size() + kCount - 1) / kCount, 256, [&](std::size_t begin, std::size_t end) {
    std::size_t met = 0;
    for (std::size_t packet = begin; packet < end; ++packet) {
      met += static_cast<std::size_t>(hits_of(kCount * packet));
    }
    hits += met;
  });
  return hits;
}

}  // namespace isolux
