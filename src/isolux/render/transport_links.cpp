#include "isolux/render/transport_links.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "isolux/base/parallel.h"
#include "isolux/render/cosine_direction.h"

namespace isolux {
namespace {

constexpr int kLanes = RayPacket::kCount;
// Enough for rays side by side to go the same way, few enough for what they meet to stay in cache.
constexpr std::size_t kSamplesAPiece = 128;
constexpr std::uint32_t kSeed = 0x11485;

// Off the surface, in its own steps: far enough for the floats of lanes to see the right side.
constexpr double kOff = 10;

constexpr std::uint32_t kSky = ~0u, kDark = kSky - 1;

}  // namespace

// Rays side by side, each for one link.
struct LinkRays {
  RayPacket packet{};
  int count = 0;
  std::uint32_t sample[kLanes];
  std::uint32_t number[kLanes];  // among the sample's rays
  Link* link[kLanes];            // where the answer goes
};

TransportLinks::TransportLinks(const Scene& scene, const SceneSurfaces& surfaces,
                               const SurfaceSamples& from, const SurfaceSamples& to, int most)
    : surfaces_(surfaces),
      from_(from),
      to_(to),
      most_(static_cast<std::size_t>(most)),
      row_of_(from.size()),
      rows_(1) {
  for (const SurfaceItem& item : scene.surfaces) opacities_.push_back(item.material.opacity);
  for (std::uint32_t n = 0; n < kSlots * most_; ++n) {
    directions_.push_back(cosine_direction(sobol_point(n, kSeed)));
  }
}

// Samples in blocks side by side have different ones.
std::uint32_t TransportLinks::slot(std::uint32_t sample) const {
  const BlockIndex block = block_of(as_double(from_.site(sample).in_blocks));
  return (block[0] & 1) | (block[1] & 1) << 1 | (block[2] & 1) << 2;
}

void TransportLinks::shoot(std::span<const std::uint32_t> samples, std::size_t count) {
  for (const std::uint32_t sample : samples) {
    if (row_of_[sample] > 0) continue;
    row_of_[sample] = static_cast<std::uint32_t>(rows_.size());
    rows_.emplace_back();
  }
  const std::size_t before = links_of(samples);
  parallel_for(samples.size(), kSamplesAPiece, [&](std::size_t begin, std::size_t end) {
    shoot_piece(samples.subspan(begin, end - begin), count);
  });
  links_ += links_of(samples) - before;
}

std::size_t TransportLinks::links_of(std::span<const std::uint32_t> samples) const {
  std::size_t links = 0;
  for (const std::uint32_t sample : samples) links += of(sample).links.capacity();
  return links;
}

void TransportLinks::shoot_piece(std::span<const std::uint32_t> samples, std::size_t count) {
  struct Start {
    std::uint32_t slot, sample;
    std::size_t first;  // of its answers
  };
  std::vector<Start> starts;
  std::size_t answers = 0;
  for (const std::uint32_t sample : samples) {
    const auto done = static_cast<std::size_t>(of(sample).rays);
    if (done >= count) continue;
    starts.push_back({slot(sample), sample, answers});
    answers += count - done;
  }
  std::ranges::stable_sort(starts, {}, &Start::slot);
  std::vector<Link> met(answers);
  LinkRays rays;
  const auto each_slot = [&](std::span<const Start> together) {
    for (std::size_t number = 0; number < count; ++number) {
      for (const auto& [slot, sample, first] : together) {
        const auto done = static_cast<std::size_t>(of(sample).rays);
        if (number < done) continue;
        const SampleSite& site = from_.site(sample);
        const TangentFrame frame(from_.normal(sample));
        const Vec3 true_normal = from_.true_normal(sample);
        const Vec3 onward =
            kept_above(frame.world(directions_[slot * most_ + number]), true_normal);
        Link& link = met[first + number - done];
        link.across = static_cast<std::int16_t>(dot(onward, frame.across) / LinkTilt::kStep);
        link.along = static_cast<std::int16_t>(dot(onward, frame.along) / LinkTilt::kStep);
        const Vec3 start =
            site.position + kOff * surfaces_.at(site.surface).step_mm() * true_normal;
        rays.packet.set(rays.count, {start, onward});
        rays.sample[rays.count] = sample;
        rays.number[rays.count] = static_cast<std::uint32_t>(number);
        rays.link[rays.count] = &link;
        if (++rays.count == kLanes) trace(rays);
      }
    }
  };
  for (std::size_t begin = 0, end; begin < starts.size(); begin = end) {
    for (end = begin + 1; end < starts.size() && starts[end].slot == starts[begin].slot;) ++end;
    each_slot({&starts[begin], end - begin});
  }
  if (rays.count > 0) trace(rays);
  for (const auto& [slot, sample, first] : starts) {
    SampleLinks& row = rows_[row_of_[sample]];
    const std::span<const Link> mine(&met[first], count - static_cast<std::size_t>(row.rays));
    const auto stays = [](const Link& link) { return link.to != kSky && link.to != kDark; };
    row.links.reserve(row.links.size() +
                      static_cast<std::size_t>(std::ranges::count_if(mine, stays)));
    for (const Link& link : mine) {
      ++row.rays;
      row.all_tilt.add(link.tilt());
      if (link.to == kSky) {
        ++row.sky;
        row.sky_tilt.add(link.tilt());
      } else if (stays(link)) {
        row.links.push_back(link);
      }
    }
  }
}

void TransportLinks::trace(LinkRays& rays) const {
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
      std::uint32_t& link = rays.link[n]->to;
      going &= ~(1u << n);
      link = kSky;
      if (!(hits.hit >> n & 1)) continue;
      Ray ray = rays.packet.ray(n);
      const double opacity = opacities_[static_cast<std::size_t>(hits.surface[n])];
      if (opacity < 1) {
        const std::uint32_t seed = mixed(mixed(kSeed + 1, rays.sample[n]), passed);
        if (sobol_point(rays.number[n], seed).u >= opacity) {
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
      const std::uint32_t found = to_.find(hits.surface[n], position, hits.point[n], outward, side);
      link = found == SurfaceSamples::kNone ? kDark : found;
    }
  }
  rays.count = 0;
}

void TransportLinks::keep(std::span<const std::uint32_t> samples, int most) {
  std::vector<SampleLinks> kept(1);
  links_ = 0;
  std::vector<std::uint32_t> row_of(row_of_.size());
  for (const std::uint32_t sample : samples) {
    if (row_of_[sample] == 0 || of(sample).rays > most) continue;
    row_of[sample] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(std::move(rows_[row_of_[sample]]));
    links_ += kept.back().links.capacity();
  }
  rows_ = std::move(kept);
  row_of_ = std::move(row_of);
}

double TransportLinks::bytes() const {
  return static_cast<double>(row_of_.size() * sizeof(row_of_[0]) +
                             rows_.capacity() * sizeof(rows_[0])) +
         link_bytes();
}

double TransportLinks::link_bytes() const { return static_cast<double>(links_ * sizeof(Link)); }

}  // namespace isolux
