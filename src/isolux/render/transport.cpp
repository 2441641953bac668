#include "isolux/render/transport.h"

#include <algorithm>
#include <bit>

#include "isolux/base/parallel.h"
#include "isolux/render/gathered_light.h"
#include "isolux/render/shadows.h"

namespace isolux {
namespace {

constexpr int kFirstLinks = 8, kLeastLinks = 16;
// Samples that are shot from between two questions whether to stop.
constexpr std::size_t kSamplesAtOnce = 1024;
constexpr std::size_t kPieceToLight = 256, kPieceToShadow = 1024;

constexpr double kBytesACoarse = 72, kBytesAFine = sizeof(SlopedLight);

std::array<float, 4> as_floats(Rgb c) {
  return {static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b), 0};
}

}  // namespace

Transport::Transport(const Scene& scene, const SceneSurfaces& surfaces, TransportOptions options)
    : surfaces_(surfaces), options_(options), links_(options.links) {
  constexpr std::pair<int, int> kEdges[] = {{1, 2}, {2, 2}, {2, 4}, {4, 4}};
  for (const auto& [fine, coarse] : kEdges) {
    fine_ = std::make_unique<SurfaceSamples>(surfaces, fine);
    coarse_ = std::make_unique<SurfaceSamples>(surfaces, coarse);
    from_fine_ = std::make_unique<TransportLinks>(scene, surfaces, *fine_, *coarse_, links_);
    from_coarse_ =
        std::make_unique<TransportLinks>(scene, surfaces, *coarse_, *coarse_, coarse_links());
    if (bytes() <= options.memory / 2) break;
  }
}

int Transport::coarse_links() const { return std::max(links_ / 16, kFirstLinks); }

void Transport::see(const Scene& scene, const SurfaceBuffer& buffer) {
  blend_.emplace(scene, surfaces_, *fine_, buffer);
  // What links take where none meets the sky. Of coarse samples hardly more than one of a site's
  // four is ever reached.
  const double left =
      options_.memory - bytes() + from_fine_->link_bytes() + from_coarse_->link_bytes();
  const auto taken = [&] {
    return static_cast<double>(sizeof(Link)) *
           (links_ * static_cast<double>(blend_->samples().size()) +
            coarse_links() * static_cast<double>(coarse_->sites().size()));
  };
  const int before = links_;
  links_ = options_.links;
  while (taken() > left && links_ > kLeastLinks) links_ /= 2;
  if (links_ < before) from_coarse_->keep({}, 0);
  if (links_ < before || bytes() > options_.memory) from_fine_->keep(blend_->samples(), links_);
  bounces_ = -1;  // needs are to be found anew
}

void Transport::need(std::uint32_t coarse, std::int8_t bounces) {
  if (needs_[coarse] >= bounces) return;
  if (needs_[coarse] < 0) sources_.push_back(coarse);
  needs_[coarse] = bounces;
  followed_[coarse] = 0;
  needing_[static_cast<std::size_t>(bounces)].push_back(coarse);
}

// What links lead to is needed with so many bounces.
void Transport::follow(const SampleLinks& row, std::uint16_t& followed, std::int8_t bounces) {
  for (; followed < row.links.size(); ++followed) need(row.links[followed].to, bounces);
}

// Calls `shot` for each sample, when it has its links.
bool Transport::shoot(TransportLinks& links, const std::vector<std::uint32_t>& samples, int count,
                      const std::function<bool()>& stop,
                      const std::function<void(std::uint32_t)>& shot) {
  const auto wanted = static_cast<std::size_t>(count);
  std::vector<std::uint32_t> lacking;
  for (std::size_t begin = 0; begin < samples.size(); begin += kSamplesAtOnce) {
    const std::size_t end = std::min(samples.size(), begin + kSamplesAtOnce);
    lacking.clear();
    for (std::size_t n = begin; n < end; ++n) {
      if (links.of(samples[n]).rays < count) lacking.push_back(samples[n]);
    }
    if (!lacking.empty()) {
      if (stop && stop()) return false;
      links.shoot(lacking, wanted);
    }
    for (std::size_t n = begin; n < end; ++n) shot(static_cast<std::uint32_t>(n));
  }
  return true;
}

bool Transport::refine(int bounces, const std::function<bool()>& stop) {
  if (bounces != bounces_) {
    bounces_ = bounces;
    needs_.assign(coarse_->size(), -1);
    followed_.assign(coarse_->size(), 0);
    sources_.clear();
    needing_.assign(static_cast<std::size_t>(std::max(bounces, 1)), {});
    fine_followed_.assign(blend_->samples().size(), 0);
  }
  if (bounces == 0) return true;
  for (int count = kFirstLinks; count <= links_; count *= 2) {
    const bool all_fine = shoot(*from_fine_, blend_->samples(), count, stop, [&](std::uint32_t n) {
      follow(from_fine_->of(blend_->samples()[n]), fine_followed_[n],
             static_cast<std::int8_t>(bounces - 1));
    });
    if (!all_fine) return false;
    for (int level = bounces - 1; level > 0; --level) {
      const std::vector<std::uint32_t> samples = needing_[static_cast<std::size_t>(level)];
      const bool all = shoot(*from_coarse_, samples, std::min(count, coarse_links()), stop,
                             [&](std::uint32_t n) {
                               follow(from_coarse_->of(samples[n]), followed_[samples[n]],
                                      static_cast<std::int8_t>(level - 1));
                             });
      if (!all) return false;
    }
  }
  return true;
}

double Transport::done() const {
  if (!blend_ || bounces_ <= 0) return bounces_ == 0 ? 1 : 0;
  double there = 0, wanted = 0;
  const auto count = [&](const SampleLinks& row, int all) {
    wanted += all;
    there += std::min(row.rays, all);
  };
  for (const std::uint32_t sample : blend_->samples()) count(from_fine_->of(sample), links_);
  for (const std::uint32_t sample : sources_) {
    if (needs_[sample] > 0) count(from_coarse_->of(sample), coarse_links());
  }
  return wanted == 0 ? 1 : there / wanted;
}

void Transport::light_directly(const Scene& scene) {
  constexpr int kLanes = PointPacket::kCount;
  constexpr double kCame = 20;  // steps; only its side of the surface matters
  const ShadowRays shadow_rays(scene, surfaces_);
  direct_.resize(coarse_->size());
  parallel_for(sources_.size(), kPieceToShadow, [&](std::size_t begin, std::size_t end) {
    std::array<Rgb, kPieceToShadow> sums{};
    // Samples that a lamp may reach, until their rays fill a packet.
    PointPacket points;
    Rgb arriving[kLanes];
    Rgb* to[kLanes];
    int count = 0;
    const auto add = [&](const Light& light) {
      float share[kLanes];
      std::ranges::fill(share, 1.0f);
      if (scene.shadows && count > 0) shadow_rays.reach(light, points, ~0u >> (32 - count), share);
      for (int n = 0; n < count; ++n) {
        *to[n] = *to[n] + static_cast<double>(share[n]) * arriving[n];
      }
      count = 0;
    };
    for (const Light& light : scene.lights) {
      for (std::size_t n = begin; n < end; ++n) {
        const std::uint32_t sample = sources_[n];
        const SampleSite& site = coarse_->site(sample);
        const SurfacePoint at{site.position, coarse_->normal(sample), coarse_->true_normal(sample)};
        arriving[count] = irradiance(light, at);
        if (arriving[count] == Rgb{}) continue;
        to[count] = &sums[n - begin];
        points.position[count] = at.position;
        points.normal[count] = at.normal;
        points.to_eye[count] = at.to_eye;
        points.came_mm[count] = kCame * surfaces_.at(site.surface).step_mm();
        points.surface[count] = site.surface;
        points.point[count] = site.point;
        if (++count == kLanes) add(light);
      }
      add(light);
    }
    for (std::size_t n = begin; n < end; ++n) direct_[sources_[n]] = as_floats(sums[n - begin]);
  });
}

void Transport::set_albedo(const Scene& scene) {
  albedo_.resize(coarse_->size());
  std::vector<SampleLight> of_surface;
  for (const SurfaceItem& item : scene.surfaces) of_surface.push_back(as_floats(item.material.kd));
  parallel_for(sources_.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const SampleSite& site = coarse_->site(sources_[n]);
      const auto surface = static_cast<std::size_t>(site.surface);
      const SurfaceItem& item = scene.surfaces[surface];
      albedo_[sources_[n]] =
          item.is_painted ? as_floats(material_at(item, site.point).kd) : of_surface[surface];
    }
  });
}

void Transport::light(const Scene& scene) {
  // Neighbours' rays go together.
  if (!std::ranges::is_sorted(sources_)) std::ranges::sort(sources_);
  light_directly(scene);
  set_albedo(scene);
  SampleLight sky = as_floats(scene.has_default_ambient ? Rgb{} : scene.ambient);
  sky[3] = 1;
  sent_.resize(coarse_->size());
  next_.resize(coarse_->size());
  const auto send = [&](std::uint32_t sample, const SampleLight& irradiance,
                        std::vector<SampleLight>& to) {
    for (std::size_t c = 0; c < 3; ++c) {
      to[sample][c] = albedo_[sample][c] * (direct_[sample][c] + irradiance[c]);
    }
  };
  parallel_for(sources_.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) send(sources_[n], {}, sent_);
  });
  for (int bounce = 1; bounce < bounces_; ++bounce) {
    parallel_for(sources_.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        const std::uint32_t sample = sources_[n];
        if (needs_[sample] < bounce) continue;
        send(sample, gathered_light(from_coarse_->of(sample), sent_.data(), sky), next_);
      }
    });
    // What needs fewer bounces keeps what it sent before: no link that counts leads there any more.
    std::swap(sent_, next_);
  }
  const std::vector<std::uint32_t>& seen = blend_->samples();
  fine_light_.assign(seen.size(), {});
  if (bounces_ == 0) return;
  parallel_for(seen.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      if (n + 1 < end) from_fine_->fetch(seen[n + 1]);
      fine_light_[n] =
          gathered_sloped(from_fine_->of(seen[n]), sent_.data(), sky, fine_->normal(seen[n]));
    }
  });
}

void Transport::gather(const SurfaceBuffer& buffer, Indirect& indirect) const {
  std::vector<float>* const channels[4] = {&indirect.pixels.r, &indirect.pixels.g,
                                           &indirect.pixels.b, &indirect.sky};
  for (std::vector<float>* channel : channels) channel->resize(buffer.pixels());
  blend_->pixels(fine_light_, buffer, channels);
  indirect.further.clear();
  if (buffer.further.empty()) return;
  for (const auto& tile : blend_->further(fine_light_, buffer)) {
    auto& to = indirect.further.emplace_back();
    for (const auto& [r, g, b, sky] : tile) to.push_back({r, g, b});
  }
}

double Transport::bytes() const {
  return fine_->bytes() + coarse_->bytes() + from_fine_->bytes() + from_coarse_->bytes() +
         static_cast<double>(coarse_->size()) * kBytesACoarse +
         (blend_ ? blend_->bytes() +
                       static_cast<double>(blend_->samples().size() * sizeof(SlopedLight))
                 : 0);
}

}  // namespace isolux
