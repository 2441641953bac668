#include "isolux/render/transport_links.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "isolux/base/parallel.h"
#include "isolux/render/cosine_direction.h"

namespace isolux {
namespace {

constexpr int kLanes = RayPacket::kCount;
constexpr std::size_t kSamplesAPiece = 32;
constexpr std::uint32_t kSeed = 0x11485;

// Off the surface, in its own steps: far enough for the floats of lanes to see the right side.
constexpr double kOff = 10;

}  // namespace

// Rays side by side, each for one link.
struct LinkRays {
  RayPacket packet{};
  int count = 0;
  std::uint32_t sample[kLanes];
  std::uint32_t link[kLanes];
};

TransportLinks::TransportLinks(const Scene& scene, const SceneSurfaces& surfaces,
                               const SurfaceSamples& from, const SurfaceSamples& to)
    : surfaces_(surfaces), from_(from), to_(to), rows_(from.size()) {
  for (const SurfaceItem& item : scene.surfaces) opacities_.push_back(item.material.opacity);
}

void TransportLinks::shoot(std::span<const std::uint32_t> samples, std::size_t count) {
  parallel_for(samples.size(), kSamplesAPiece, [&](std::size_t begin, std::size_t end) {
    shoot_piece(samples.subspan(begin, end - begin), count);
  });
}

void TransportLinks::shoot_piece(std::span<const std::uint32_t> samples, std::size_t count) {
  LinkRays rays;
  for (const std::uint32_t sample : samples) {
    std::vector<std::uint32_t>& row = rows_[sample];
    const std::size_t done = row.size();
    if (done >= count) continue;
    row.reserve(count);
    row.resize(count);
    const SampleSite& site = from_.site(sample);
    const Vec3 normal = from_.normal(sample), true_normal = from_.true_normal(sample);
    const Vec3 start = site.position + kOff * surfaces_.at(site.surface).step_mm() * true_normal;
    for (std::size_t link = done; link < count; ++link) {
      const auto number = static_cast<std::uint32_t>(link);
      Vec3 onward = cosine_direction(normal, sobol_point(number, mixed(kSeed, sample)));
      const double down = dot(onward, true_normal);
      if (down < 0) onward = onward - 2 * down * true_normal;
      rays.packet.set(rays.count, {start, onward});
      rays.sample[rays.count] = sample;
      rays.link[rays.count] = number;
      if (++rays.count == kLanes) trace(rays);
    }
  }
  if (rays.count > 0) trace(rays);
}

void TransportLinks::trace(LinkRays& rays) {
  std::uint32_t going = ~0u >> (kLanes - rays.count);
  for (int n = 0; n < kLanes; ++n) {
    rays.packet.begin[n] = 0;
    rays.packet.end[n] = std::numeric_limits<float>::infinity();
    if (n >= rays.count) rays.packet.set(n, rays.packet.ray(0));
  }
  for (std::uint32_t passed = 0; going != 0; ++passed) {
    PacketHits hits;
    for (std::size_t s = 0; s < surfaces_.all().size(); ++s) {
      surfaces_.all()[s].first_hits(rays.packet, going, static_cast<std::int32_t>(s), hits);
    }
    for (std::uint32_t rest = going; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      std::uint32_t& link = rows_[rays.sample[n]][rays.link[n]];
      going &= ~(1u << n);
      link = sky();
      if (!(hits.hit >> n & 1)) continue;
      Ray ray = rays.packet.ray(n);
      const double opacity = opacities_[static_cast<std::size_t>(hits.surface[n])];
      if (opacity < 1) {
        const std::uint32_t seed = mixed(mixed(kSeed + 1, rays.sample[n]), passed);
        if (sobol_point(rays.link[n], seed).u >= opacity) {
          ray.origin = ray.at(hits.t[n] + kOff * surfaces_.at(hits.surface[n]).step_mm());
          rays.packet.set(n, ray);
          going |= 1u << n;
          continue;
        }
      }
      hits.face(n, ray.direction);
      const Vec3 normal{hits.normal[0][n], hits.normal[1][n], hits.normal[2][n]};
      const bool turned = (hits.turned >> n & 1) != 0;
      const Vec3 position = ray.at(hits.t[n]);
      const Vec3 outward = turned ? -normal : normal;
      const PreparedSurface& surface = surfaces_.at(hits.surface[n]);
      // The isosurface that a ray has left, it meets from the side that it left.
      const bool stays =
          passed == 0 && surface.lanes() && hits.surface[n] == from_.site(rays.sample[n]).surface;
      SeenSide side;
      side.inside = stays ? from_.side(rays.sample[n]).inside
                          : is_inside(surface, position, hits.point[n], outward, ray.direction);
      side.flipped = turned != side.inside;
      const std::uint32_t found = to_.find(hits.surface[n], position, outward, side);
      link = found == SurfaceSamples::kNone ? dark() : found;
    }
  }
  rays.count = 0;
}

void TransportLinks::keep(std::span<const std::uint32_t> samples) {
  std::size_t next = 0;
  for (std::uint32_t n = 0; n < rows_.size(); ++n) {
    if (next < samples.size() && samples[next] == n) {
      ++next;
    } else if (!rows_[n].empty()) {
      rows_[n] = {};
    }
  }
}

double TransportLinks::bytes() const {
  return static_cast<double>(rows_.size() * sizeof(rows_[0])) + link_bytes();
}

double TransportLinks::link_bytes() const {
  std::size_t links = 0;
  for (const auto& row : rows_) links += row.capacity();
  return static_cast<double>(links * sizeof(std::uint32_t));
}

}  // namespace isolux
