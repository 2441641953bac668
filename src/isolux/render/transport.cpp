#include "isolux/render/transport.h"

#include <algorithm>

#include "isolux/base/parallel.h"
#include "isolux/render/shadows.h"

namespace isolux {
namespace {

constexpr std::size_t kFirstLinks = 8, kLeastLinks = 32;
// Samples that are shot from between two questions whether to stop.
constexpr std::size_t kSamplesAtOnce = 1024;
constexpr std::size_t kPieceToLight = 256;
constexpr double kBytesASample = 136;

std::array<float, 4> as_floats(Rgb c) {
  return {static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b), 0};
}

}  // namespace

Transport::Transport(const Scene& scene, const SceneSurfaces& surfaces, TransportOptions options)
    : surfaces_(surfaces), options_(options) {
  for (int edge = getenv("EDGE") ? atoi(getenv("EDGE")) : 2;; edge = 4) {
    samples_ = std::make_unique<SurfaceSamples>(surfaces, edge);
    const auto bytes = [&] {
      return static_cast<double>(samples_->size()) * (kBytesASample + 4.0 * options_.links);
    };
    options_.links = options.links;
    while (bytes() > options.memory && options_.links > static_cast<int>(kLeastLinks)) {
      options_.links /= 2;
    }
    if (bytes() <= options.memory || edge == 4) break;
  }
  links_ = std::make_unique<TransportLinks>(scene, surfaces, *samples_);
}

void Transport::see(const Scene& scene, const SurfaceBuffer& buffer) {
  blend_.emplace(scene, surfaces_, *samples_, buffer);
  bounces_ = -1;  // needs are to be found anew
}

std::size_t Transport::wanted(std::int8_t need) const {
  const auto links = static_cast<std::size_t>(options_.links);
  return need == 0 ? 0 : need == bounces_ ? links : std::max(links / 4, kFirstLinks);
}

void Transport::need(std::uint32_t sample, std::int8_t bounces) {
  if (needs_[sample] >= bounces) return;
  needs_[sample] = bounces;
  followed_[sample] = 0;
  needing_[static_cast<std::size_t>(bounces)].push_back(sample);
}

// What a sample's links lead to is needed for one bounce less.
void Transport::follow(std::uint32_t sample) {
  const std::int8_t level = needs_[sample];
  const auto links = links_->of(sample);
  const std::size_t last = std::min(links.size(), wanted(level));
  for (std::size_t n = followed_[sample]; n < last; ++n) {
    const std::uint32_t to = links[n];
    if (to >= samples_->size()) continue;
    if (!is_source_[to]) {
      is_source_[to] = true;
      sources_.push_back(to);
    }
    need(to, static_cast<std::int8_t>(level - 1));
  }
  followed_[sample] = static_cast<std::uint16_t>(last);
}

bool Transport::refine(int bounces, const std::function<bool()>& stop) {
  if (bounces != bounces_) {
    bounces_ = bounces;
    needs_.assign(samples_->size(), kUnneeded);
    followed_.assign(samples_->size(), 0);
    is_source_.assign(samples_->size(), false);
    sources_.clear();
    needing_.assign(static_cast<std::size_t>(bounces) + 1, {});
    for (const std::uint32_t sample : blend_->samples()) {
      need(sample, static_cast<std::int8_t>(bounces));
    }
  }
  if (bounces == 0) return true;
  for (std::size_t count = kFirstLinks; count <= static_cast<std::size_t>(options_.links);
       count *= 2) {
    if (!refine_round(count, stop)) return false;
  }
  return true;
}

bool Transport::refine_round(std::size_t count, const std::function<bool()>& stop) {
  std::vector<std::uint32_t> lacking;
  for (int bounce = bounces_; bounce > 0; --bounce) {
    const auto level = static_cast<std::int8_t>(bounce);
    const std::size_t most = std::min(count, wanted(level));
    const std::vector<std::uint32_t>& level_samples = needing_[static_cast<std::size_t>(bounce)];
    for (std::size_t begin = 0; begin < level_samples.size(); begin += kSamplesAtOnce) {
      const std::size_t end = std::min(level_samples.size(), begin + kSamplesAtOnce);
      lacking.clear();
      for (std::size_t n = begin; n < end; ++n) {
        if (links_->of(level_samples[n]).size() < most) lacking.push_back(level_samples[n]);
      }
      if (!lacking.empty()) {
        if (stop && stop()) return false;
        links_->shoot(lacking, most);
      }
      for (std::size_t n = begin; n < end; ++n) follow(level_samples[n]);
    }
  }
  return true;
}

double Transport::done() const {
  if (!blend_ || blend_->samples().empty()) return 1;
  double sum = 0;
  for (const std::uint32_t sample : blend_->samples()) {
    sum += static_cast<double>(links_->of(sample).size());
  }
  return std::min(1.0, sum / (options_.links * static_cast<double>(blend_->samples().size())));
}

void Transport::light_directly(const Scene& scene) {
  constexpr int kLanes = PointPacket::kCount;
  const ShadowRays shadow_rays(scene, surfaces_);
  direct_.resize(samples_->size());
  const std::size_t packets = (sources_.size() + kLanes - 1) / kLanes;
  parallel_for(packets, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t packet = begin; packet < end; ++packet) {
      PointPacket points;
      const std::size_t first = packet * kLanes;
      const int count = static_cast<int>(std::min<std::size_t>(kLanes, sources_.size() - first));
      for (int n = 0; n < count; ++n) {
        const std::uint32_t sample = sources_[first + static_cast<std::size_t>(n)];
        const SampleSite& site = samples_->site(sample);
        points.position[n] = site.position;
        points.normal[n] = samples_->normal(sample);
        points.to_eye[n] = samples_->true_normal(sample);
        points.came_mm[n] = 20 * surfaces_.at(site.surface).step_mm();
        points.surface[n] = site.surface;
        points.point[n] = site.point;
      }
      Rgb sums[kLanes] = {};
      for (const Light& light : scene.lights) {
        Rgb arriving[kLanes];
        std::uint32_t lit = 0;
        for (int n = 0; n < count; ++n) {
          arriving[n] = irradiance(light, {points.position[n], points.normal[n], points.to_eye[n]});
          if (arriving[n] != Rgb{}) lit |= 1u << n;
        }
        if (lit == 0) continue;
        float share[kLanes];
        std::ranges::fill(share, 1.0f);
        if (scene.shadows) shadow_rays.reach(light, points, lit, share);
        for (std::uint32_t rest = lit; rest != 0; rest &= rest - 1) {
          const int n = std::countr_zero(rest);
          sums[n] = sums[n] + static_cast<double>(share[n]) * arriving[n];
        }
      }
      for (int n = 0; n < count; ++n) {
        direct_[sources_[first + static_cast<std::size_t>(n)]] = as_floats(sums[n]);
      }
    }
  });
}

void Transport::set_albedo(const Scene& scene) {
  albedo_.resize(samples_->size());
  std::vector<Radiance4> of_surface;
  for (const SurfaceItem& item : scene.surfaces) of_surface.push_back(as_floats(item.material.kd));
  parallel_for(sources_.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const SampleSite& site = samples_->site(sources_[n]);
      const auto surface = static_cast<std::size_t>(site.surface);
      const SurfaceItem& item = scene.surfaces[surface];
      albedo_[sources_[n]] =
          item.is_painted ? as_floats(material_at(item, site.point).kd) : of_surface[surface];
    }
  });
}

void Transport::light(const Scene& scene) {
  std::ranges::sort(sources_);
  for (auto& level : needing_) level.clear();
  for (std::uint32_t n = 0; n < needs_.size(); ++n) {
    if (needs_[n] > 0) needing_[static_cast<std::size_t>(needs_[n])].push_back(n);
  }
  light_directly(scene);
  set_albedo(scene);
  const Radiance4 sky = as_floats(scene.has_default_ambient ? Rgb{} : scene.ambient);
  for (auto* radiance : {&sent_, &next_}) {
    radiance->resize(samples_->size() + 2);
    (*radiance)[links_->sky()] = sky;
    (*radiance)[links_->dark()] = {};
  }
  const auto send = [&](std::uint32_t sample, const Radiance4& indirect,
                        std::vector<Radiance4>& to) {
    for (std::size_t c = 0; c < 3; ++c) {
      to[sample][c] = albedo_[sample][c] * (direct_[sample][c] + indirect[c]);
    }
  };
  for (const std::uint32_t sample : sources_) send(sample, {}, sent_);
  irradiance_.resize(samples_->size());

  for (int bounce = 1; bounce <= bounces_; ++bounce) {
    for (int level = bounce; level <= bounces_; ++level) {
      const std::vector<std::uint32_t>& at = needing_[static_cast<std::size_t>(level)];
      const std::size_t most = wanted(static_cast<std::int8_t>(bounce < bounces_ ? 1 : level));
      parallel_for(at.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
          const auto all = links_->of(at[n]);
          const auto links = all.first(std::min(all.size(), most));
          Radiance4 sum{};
          std::size_t open = 0;
          for (const std::uint32_t link : links) {
            const Radiance4& from = sent_[link];
            for (std::size_t c = 0; c < 4; ++c) sum[c] += from[c];
            open += link == links_->sky();
          }
          const float share = links.empty() ? 0 : 1 / static_cast<float>(links.size());
          for (std::size_t c = 0; c < 3; ++c) sum[c] *= share;
          sum[3] = static_cast<float>(open) * share;
          if (bounce < bounces_) {
            send(at[n], sum, next_);
          } else {
            irradiance_[at[n]] = sum;
          }
        }
      });
    }
    if (bounce == bounces_) break;
    // Where nothing more is needed, nothing more leaves; no link that is followed leads there.
    std::swap(sent_, next_);
  }
}

void Transport::gather(const SurfaceBuffer& buffer, Indirect& indirect) const {
  std::vector<float>* const channels[4] = {&indirect.pixels.r, &indirect.pixels.g,
                                           &indirect.pixels.b, &indirect.sky};
  for (std::vector<float>* channel : channels) channel->resize(buffer.pixels());
  blend_->pixels(irradiance_.data(), channels);
  indirect.further.clear();
  if (buffer.further.empty()) return;
  for (const auto& tile : blend_->further(irradiance_.data())) {
    auto& to = indirect.further.emplace_back();
    for (const auto& [r, g, b, sky] : tile) to.push_back({r, g, b});
  }
}

double Transport::bytes() const {
  const double of_samples =
      static_cast<double>(samples_->size()) * (5 * sizeof(Radiance4) + sizeof(std::int8_t) + 8);
  return samples_->bytes() + links_->bytes() + of_samples + (blend_ ? blend_->bytes() : 0);
}

}  // namespace isolux
