#include "isolux/render/transport_links.h"

#include <algorithm>
#include <limits>

#include "isolux/base/parallel.h"
#include "isolux/render/cosine_direction.h"

namespace isolux {
namespace {

// Enough for rays side by side to go the same way, few enough for what they meet to stay in cache.
constexpr std::size_t kSamplesAPiece = 128;
constexpr std::uint32_t kSeed = 0x11485;

}  // namespace

TransportLinks::TransportLinks(const Scene& scene, const SceneSurfaces& surfaces,
                               const SurfaceSamples& from, const SurfaceSamples& to, int most)
    : surfaces_(surfaces),
      from_(from),
      tracer_(scene, surfaces, to),
      most_(static_cast<std::size_t>(most)),
      row_of_(from.size()),
      rows_(1) {
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
    std::size_t done;   // rays that were shot before
    TangentFrame frame;
    Vec3 true_normal, position;  // the latter a little above the surface
  };
  std::vector<Start> starts;
  std::size_t answers = 0;
  for (const std::uint32_t sample : samples) {
    const auto done = static_cast<std::size_t>(of(sample).rays);
    if (done >= count) continue;
    const SampleSite& site = from_.site(sample);
    const Vec3 true_normal = from_.true_normal(sample);
    const double off = LinkTracer::kOff * surfaces_.at(site.surface).step_mm();
    starts.push_back({slot(sample), sample, answers, done, TangentFrame(from_.normal(sample)),
                      true_normal, site.position + off * true_normal});
    answers += count - done;
  }
  std::ranges::stable_sort(starts, {}, &Start::slot);
  struct Met {
    Link link;
    bool is_close;
  };
  std::vector<Met> met(answers);
  LinkRays rays;
  std::ranges::fill(rays.reach_mm, std::numeric_limits<float>::infinity());
  std::array<Met*, LinkRays::kCount> answer;
  const auto trace = [&] {
    tracer_.trace(rays);
    for (int n = 0; n < rays.count; ++n) {
      Met& at = *answer[static_cast<std::size_t>(n)];
      at.link.to = rays.to[n];
      at.is_close = rays.distance_mm[n] <= from_.close_mm(rays.surface[n]);
    }
    rays.count = 0;
  };
  const auto each_slot = [&](std::span<const Start> together) {
    for (std::size_t number = 0; number < count; ++number) {
      for (const Start& start : together) {
        if (number < start.done) continue;
        const TangentFrame& frame = start.frame;
        const Vec3 onward =
            kept_above(frame.world(directions_[start.slot * most_ + number]), start.true_normal);
        Met& at = met[start.first + number - start.done];
        at.link.across = static_cast<std::int16_t>(dot(onward, frame.across) / LinkTilt::kStep);
        at.link.along = static_cast<std::int16_t>(dot(onward, frame.along) / LinkTilt::kStep);
        const int n = rays.count++;
        rays.set(n, {start.position, onward});
        rays.surface[n] = from_.site(start.sample).surface;
        rays.inside[n] = from_.side(start.sample).inside;
        rays.seed[n] = start.sample;
        rays.number[n] = static_cast<std::uint32_t>(number);
        answer[static_cast<std::size_t>(n)] = &at;
        if (rays.count == LinkRays::kCount) trace();
      }
    }
  };
  for (std::size_t begin = 0, end; begin < starts.size(); begin = end) {
    for (end = begin + 1; end < starts.size() && starts[end].slot == starts[begin].slot;) ++end;
    each_slot({&starts[begin], end - begin});
  }
  if (rays.count > 0) trace();
  for (const Start& start : starts) {
    SampleLinks& row = rows_[row_of_[start.sample]];
    const std::span<const Met> mine(&met[start.first], count - start.done);
    const auto stays = [](const Met& one) {
      return one.link.to != LinkRays::kSky && one.link.to != LinkRays::kDark;
    };
    row.links.reserve(row.links.size() +
                      static_cast<std::size_t>(std::ranges::count_if(mine, stays)));
    for (const Met& one : mine) {
      ++row.rays;
      row.all_tilt.add(one.link.tilt());
      if (one.link.to == LinkRays::kSky) {
        ++row.sky;
        row.sky_tilt.add(one.link.tilt());
      } else if (stays(one)) {
        if (one.is_close) row.close.push_back(static_cast<std::uint16_t>(row.links.size()));
        row.links.push_back(one.link);
      }
    }
  }
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
