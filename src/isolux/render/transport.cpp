#include "isolux/render/transport.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <span>

#include "isolux/base/parallel.h"
#include "isolux/render/gathered_light.h"
#include "isolux/render/shadows.h"

namespace isolux {
namespace {

constexpr int kFirstLinks = 8, kLeastLinks = 16;
// What is shot between two questions whether to stop.
constexpr std::size_t kRaysAtOnce = 1 << 16, kLeastAtOnce = 256;
// Samples whose links are fetched while others are gathered.
constexpr std::size_t kAhead = 2;
constexpr std::size_t kPieceToLight = 256, kPieceToShadow = 1024, kPieceToFollow = 2048;

// Of a coarse sample: its needs and followed links, where it stands among others, D and kd; and
// what it sends with each bounce.
constexpr double kBytesACoarse = 1 + 1 + 2 + 4 + 4 + 12 + 12, kBytesABounce = 12;
constexpr double kBytesAFine = 4 * sizeof(SlopedLight);

bool is_grey(Rgb c) { return c.r == c.g && c.g == c.b; }

Rgb sky_of(const Scene& scene) { return scene.has_default_ambient ? Rgb{} : scene.ambient; }

bool is_grey(const Scene& scene) {
  return is_grey(sky_of(scene)) &&
         std::ranges::all_of(scene.lights,
                             [](const Light& light) { return is_grey(light.intensity); }) &&
         std::ranges::all_of(scene.surfaces, [](const SurfaceItem& item) {
           return !item.is_painted && is_grey(item.material.kd);
         });
}

void set_channels(Rgb value, std::size_t channels, float* to) {
  for (std::size_t c = 0; c < channels; ++c) to[c] = static_cast<float>(value[static_cast<int>(c)]);
}

// Whether surfaces send the same light in both.
bool is_lit_alike(const Scene& a, const Scene& b) {
  return a.lights == b.lights && a.shadows == b.shadows && sky_of(a) == sky_of(b) &&
         std::ranges::equal(a.surfaces, b.surfaces, [](const auto& one, const auto& other) {
           return one.material == other.material && one.change == other.change;
         });
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

void Transport::see(const Scene& scene, const SurfaceBuffer& buffer, PixelBlend::Detail detail) {
  const std::vector<std::uint32_t> before =
      blend_ ? blend_->samples() : std::vector<std::uint32_t>();
  blend_.emplace(scene, surfaces_, *fine_, buffer, detail);
  buffer_ = &buffer;
  camera_ = scene.camera;
  close_.reset();
  has_room_for_close_ = true;
  is_close_known_ = false;
  // What links take where none meets the sky. Of coarse samples hardly more than one of a site's
  // four is ever reached.
  const double left =
      options_.memory - bytes() + from_fine_->link_bytes() + from_coarse_->link_bytes();
  const auto taken = [&] {
    return static_cast<double>(sizeof(Link)) *
           (links_ * static_cast<double>(blend_->samples().size()) +
            coarse_links() * static_cast<double>(coarse_->sites().size()));
  };
  const int links_before = links_;
  links_ = options_.links;
  while (taken() > left && links_ > kLeastLinks) links_ /= 2;
  const bool has_fewer = links_ < links_before;
  if (has_fewer) from_coarse_->keep({}, 0);
  if (has_fewer || bytes() > options_.memory) from_fine_->keep(blend_->samples(), links_);
  if (has_fewer) lit_by_.reset();
  keep_known(before);
  refined_ = 0;
  // A picture's needs are found anew. While the eye moves what it needed before stays.
  if (detail == PixelBlend::Detail::kWhole || has_fewer) bounces_ = -1;
}

// Takes what is known of fine samples to where they stand now.
void Transport::keep_known(const std::vector<std::uint32_t>& before) {
  const std::vector<std::uint32_t>& seen = blend_->samples();
  std::vector<SlopedLight> light(seen.size() * channels_);
  std::vector<std::uint16_t> rays(seen.size()), followed(seen.size());
  for (std::size_t n = 0, old = 0; n < seen.size(); ++n) {
    while (old < before.size() && before[old] < seen[n]) ++old;
    if (old == before.size()) break;
    if (before[old] != seen[n]) continue;
    if (old < fine_followed_.size()) followed[n] = fine_followed_[old];
    if (old >= fine_rays_.size()) continue;
    rays[n] = fine_rays_[old];
    std::copy_n(&fine_light_[channels_ * old], channels_, &light[channels_ * n]);
  }
  fine_light_ = std::move(light);
  fine_rays_ = std::move(rays);
  fine_followed_ = std::move(followed);
}

// What links lead to is needed with so many bounces. Threads may say so of the same sample.
void Transport::follow(const SampleLinks& row, std::uint16_t& followed, std::int8_t bounces) {
  for (; followed < row.links.size(); ++followed) {
    const std::atomic_ref<std::int8_t> needed(needs_[row.links[followed].to]);
    if (needed.load(std::memory_order_relaxed) < bounces) {
      needed.store(bounces, std::memory_order_relaxed);
    }
  }
}

// Notes what has come to need so many bounces.
void Transport::collect(std::int8_t bounces) {
  constexpr std::size_t kAtOnce = 64;  // mostly nothing has changed
  const auto size = static_cast<std::uint32_t>(needs_.size());
  for (std::uint32_t begin = 0; begin < size; begin += kAtOnce) {
    const std::uint32_t end = std::min<std::uint32_t>(size, begin + kAtOnce);
    if (std::memcmp(&needs_[begin], &collected_[begin], end - begin) == 0) continue;
    for (std::uint32_t sample = begin; sample < end; ++sample) {
      if (needs_[sample] != bounces || collected_[sample] == bounces) continue;
      if (collected_[sample] < 0) sources_.push_back(sample);
      collected_[sample] = bounces;
      followed_[sample] = 0;
      needing_[static_cast<std::size_t>(bounces)].push_back(sample);
    }
  }
}

// Shoots what is missing, and asks in between whether to stop; returns whether all is there.
bool Transport::shoot(TransportLinks& links, const std::vector<std::uint32_t>& samples, int count,
                      const std::function<bool()>& stop) {
  std::vector<std::uint32_t> lacking;
  for (const std::uint32_t sample : samples) {
    if (links.of(sample).rays < count) lacking.push_back(sample);
  }
  // What was lit by way of fewer links is to be lit again.
  const bool changes_light =
      &links == from_coarse_.get() && !known_.empty() &&
      std::ranges::any_of(lacking, [&](std::uint32_t sample) { return known_[sample] > 1; });
  if (changes_light) lit_by_.reset();
  const std::size_t at_once =
      std::max<std::size_t>(kLeastAtOnce, kRaysAtOnce / static_cast<std::size_t>(count));
  const std::span<const std::uint32_t> all(lacking);
  for (std::size_t begin = 0; begin < all.size(); begin += at_once) {
    if (stop && stop()) return false;
    links.shoot(all.subspan(begin, std::min(at_once, all.size() - begin)),
                static_cast<std::size_t>(count));
  }
  return true;
}

// Finds what links lead to, and shoots for those coarse samples that need more than direct light,
// as long as `is_whole`; returns whether all is there.
bool Transport::shoot_coarse(int bounces, int count, bool is_whole,
                             const std::function<bool()>& stop) {
  for (int level = bounces - 1; level >= 0; --level) {
    collect(static_cast<std::int8_t>(level));
    if (level == 0) break;
    const std::vector<std::uint32_t>& samples = needing_[static_cast<std::size_t>(level)];
    is_whole = is_whole && shoot(*from_coarse_, samples, std::min(count, coarse_links()), stop);
    parallel_for(samples.size(), kPieceToFollow, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        if (needs_[samples[n]] > level) continue;
        follow(from_coarse_->of(samples[n]), followed_[samples[n]],
               static_cast<std::int8_t>(level - 1));
      }
    });
  }
  return is_whole;
}

// From the picture's points.
bool Transport::shoot_close(int bounces, const std::function<bool()>& stop) {
  if (is_close_known_ || !has_room_for_close_) return true;
  const std::vector<std::uint32_t>& seen = blend_->samples();
  if (!close_) {
    std::vector<SlopedLight> shares(seen.size());
    parallel_for(seen.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        shares[n] = close_share(from_fine_->of(seen[n]), fine_->normal(seen[n]));
      }
    });
    std::vector<float> close(buffer_->pixels());
    float* const to = close.data();
    blend_->pixels(shares, *buffer_, {&to, 1});
    close_.emplace(from_fine_->tracer(), surfaces_, *fine_, *buffer_, *camera_, std::move(close));
  }
  if (!close_->shoot(stop)) return false;
  if (bytes() > options_.memory) from_fine_->keep(seen, links_);
  if (bytes() > options_.memory) {
    close_.reset();
    has_room_for_close_ = false;
    return true;
  }
  const auto needed = static_cast<std::int8_t>(bounces - 1);
  close_->each_sender([&](std::uint32_t to) { needs_[to] = std::max(needs_[to], needed); });
  is_close_known_ = shoot_coarse(bounces, links_, true, stop);
  return is_close_known_;
}

bool Transport::refine(int bounces, const std::function<bool()>& stop) {
  if (bounces != bounces_) {
    bounces_ = bounces;
    refined_ = 0;
    needs_.assign(coarse_->size(), -1);
    collected_ = needs_;
    followed_.assign(coarse_->size(), 0);
    sources_.clear();
    needing_.assign(static_cast<std::size_t>(std::max(bounces, 1)), {});
    fine_followed_.assign(blend_->samples().size(), 0);
    is_close_known_ = false;
  }
  if (bounces == 0) return true;
  const bool is_sketch = blend_->detail() == PixelBlend::Detail::kSketch;
  const int wanted = is_sketch ? kFirstLinks : links_;
  for (int count = std::max(kFirstLinks, 2 * refined_); count <= wanted; count *= 2) {
    const std::vector<std::uint32_t>& seen = blend_->samples();
    const bool is_whole = shoot(*from_fine_, seen, count, stop);
    parallel_for(seen.size(), kPieceToFollow, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        follow(from_fine_->of(seen[n]), fine_followed_[n], static_cast<std::int8_t>(bounces - 1));
      }
    });
    if (!shoot_coarse(bounces, count, is_whole, stop)) return false;
    refined_ = count;
  }
  return !is_sketch && shoot_close(bounces, stop);
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
  if (close_) {
    wanted += close_->rays();
    there += close_->rays() * close_->done();
  }
  return wanted == 0 ? 1 : there / wanted;
}

void Transport::light_directly(const Scene& scene, const std::vector<std::uint32_t>& sources) {
  constexpr std::size_t kLanes = PointPacket::kCount;
  constexpr double kCame = 20;  // steps; only its side of the surface matters
  const ShadowRays shadow_rays(scene, surfaces_);
  parallel_for(sources.size(), kPieceToShadow, [&](std::size_t begin, std::size_t end) {
    std::array<Rgb, kPieceToShadow> sums{};
    // Samples that a lamp may reach, until their rays fill the packets that go together.
    constexpr std::size_t kPackets = IsoLanes::kPacketsAtOnce;
    std::array<PointPacket, kPackets> points;
    std::array<ShadowQuestion, kPackets> questions;
    std::array<Rgb, kPackets * kLanes> arriving;
    std::array<Rgb*, kPackets * kLanes> to;
    std::size_t count = 0;
    const auto add = [&](const Light& light) {
      const std::size_t packets = (count + kLanes - 1) / kLanes;
      for (std::size_t p = 0; p < packets; ++p) {
        const std::size_t here = std::min(kLanes, count - p * kLanes);
        questions[p] = {&points[p], ~0u >> (kLanes - here), {}, {}};
        std::ranges::fill(questions[p].share, 1.0f);
      }
      if (scene.shadows) shadow_rays.reach(light, std::span(questions).first(packets));
      for (std::size_t n = 0; n < count; ++n) {
        const float share = questions[n / kLanes].share[n % kLanes];
        *to[n] = *to[n] + static_cast<double>(share) * arriving[n];
      }
      count = 0;
    };
    for (const Light& light : scene.lights) {
      for (std::size_t n = begin; n < end; ++n) {
        const std::uint32_t sample = sources[n];
        const SampleSite& site = coarse_->site(sample);
        const SurfacePoint at{site.position, coarse_->normal(sample), coarse_->true_normal(sample)};
        arriving[count] = irradiance(light, at);
        if (arriving[count] == Rgb{}) continue;
        to[count] = &sums[n - begin];
        PointPacket& packet = points[count / kLanes];
        const std::size_t lane = count % kLanes;
        packet.position[lane] = at.position;
        packet.normal[lane] = at.normal;
        packet.to_eye[lane] = at.to_eye;
        packet.came_mm[lane] = kCame * surfaces_.at(site.surface).step_mm();
        packet.surface[lane] = site.surface;
        packet.point[lane] = site.point;
        if (++count == arriving.size()) add(light);
      }
      add(light);
    }
    for (std::size_t n = begin; n < end; ++n) {
      set_channels(sums[n - begin], channels_, &direct_[channels_ * sources[n]]);
    }
  });
}

void Transport::set_albedo(const Scene& scene, const std::vector<std::uint32_t>& sources) {
  parallel_for(sources.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const SampleSite& site = coarse_->site(sources[n]);
      const SurfaceItem& item = scene.surfaces[static_cast<std::size_t>(site.surface)];
      set_channels(item.is_painted ? material_at(item, site.point).kd : item.material.kd, channels_,
                   &albedo_[channels_ * sources[n]]);
    }
  });
}

// Finds what sources send with so many bounces, which is what the next bounce gathers.
void Transport::send(const std::vector<std::uint32_t>& sources, std::size_t bounce,
                     SentLight& light) {
  float* const to = sent_[bounce].data();
  parallel_for(sources.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const std::uint32_t sample = sources[n];
      std::array<float, SentLight::kMost> irradiance{};
      if (bounce > 0) {
        if (n + kAhead < end) from_coarse_->fetch(sources[n + kAhead]);
        irradiance = gathered_light(from_coarse_->of(sample), light);
      }
      for (std::size_t c = 0; c < channels_; ++c) {
        const std::size_t at = channels_ * sample + c;
        to[at] = albedo_[at] * (direct_[at] + irradiance[c]);
      }
      known_[sample] = static_cast<std::int8_t>(bounce + 1);
    }
  });
  light.of_samples = to;
}

void Transport::light(const Scene& scene) {
  // Neighbours' rays go together.
  const auto fresh = std::ranges::is_sorted_until(sources_);
  std::ranges::sort(fresh, sources_.end());
  std::ranges::inplace_merge(sources_, fresh);
  if (!lit_by_ || !is_lit_alike(*lit_by_, scene)) {
    known_.assign(coarse_->size(), 0);
    lit_bounces_ = -1;
  }
  const bool had_close = is_close_lit_;
  is_close_lit_ = is_close_known_ && close_;
  if (lit_bounces_ != bounces_ || had_close != is_close_lit_) {
    std::ranges::fill(fine_rays_, std::uint16_t{0});
  }
  lit_by_ = scene;
  lit_bounces_ = bounces_;
  channels_ = is_grey(scene) ? 1 : SentLight::kMost;
  const std::size_t size = coarse_->size() * channels_;
  direct_.resize(size);
  albedo_.resize(size);
  sent_.resize(static_cast<std::size_t>(std::max(bounces_, 1)));
  for (std::vector<float>& sent : sent_) sent.resize(size);
  SentLight light{channels_, nullptr, {}};
  set_channels(sky_of(scene), SentLight::kMost, light.sky.data());
  std::vector<std::uint32_t> lacking;
  for (int bounce = 0; bounce < std::max(bounces_, 1); ++bounce) {
    lacking.clear();
    std::ranges::copy_if(sources_, std::back_inserter(lacking), [&](std::uint32_t sample) {
      return needs_[sample] >= bounce && known_[sample] <= bounce;
    });
    if (bounce == 0) {
      light_directly(scene, lacking);
      set_albedo(scene, lacking);
    }
    send(lacking, static_cast<std::size_t>(bounce), light);
  }
  const std::vector<std::uint32_t>& seen = blend_->samples();
  fine_light_.resize(seen.size() * channels_);
  fine_rays_.resize(seen.size());
  if (bounces_ == 0) std::ranges::fill(fine_light_, SlopedLight{});
  if (bounces_ == 0) return;
  parallel_for(seen.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const SampleLinks& row = from_fine_->of(seen[n]);
      if (row.rays > 0 && fine_rays_[n] == row.rays) continue;
      fine_rays_[n] = static_cast<std::uint16_t>(row.rays);
      if (n + kAhead < end) from_fine_->fetch(seen[n + kAhead]);
      const auto gather = is_close_lit_ ? gather_further : gather_sloped;
      gather(row, light, fine_->normal(seen[n]), &fine_light_[channels_ * n]);
    }
  });
  all_fine_light_.clear();
  if (!is_close_lit_ || buffer_->further.empty()) return;
  all_fine_light_.resize(fine_light_.size());
  parallel_for(seen.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      gather_sloped(from_fine_->of(seen[n]), light, fine_->normal(seen[n]),
                    &all_fine_light_[channels_ * n]);
    }
  });
}

void Transport::gather(const SurfaceBuffer& buffer, Indirect& indirect) const {
  RgbLayer& pixels = indirect.pixels;
  for (auto* channel : {&pixels.r, &pixels.g, &pixels.b}) channel->resize(buffer.pixels());
  float* const channels[] = {pixels.r.data(), pixels.g.data(), pixels.b.data()};
  blend_->pixels(fine_light_, buffer, channels);
  if (is_close_lit_) close_->add({channels_, sent_.back().data(), {}}, indirect.pixels);
  indirect.further.clear();
  if (buffer.further.empty()) return;
  indirect.further = blend_->further(is_close_lit_ ? all_fine_light_ : fine_light_, buffer);
}

void Transport::gather_sky(const SurfaceBuffer& buffer, Indirect& indirect) const {
  const std::vector<std::uint32_t>& seen = blend_->samples();
  std::vector<SlopedLight> skies(seen.size());
  if (bounces_ > 0) {
    parallel_for(seen.size(), kPieceToLight, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        skies[n] = sloped_sky(from_fine_->of(seen[n]), fine_->normal(seen[n]));
      }
    });
  }
  indirect.sky.resize(buffer.pixels());
  float* const sky = indirect.sky.data();
  blend_->pixels(skies, buffer, {&sky, 1});
  if (is_close_lit_) close_->dim_sky(indirect.sky);
  for (float& share : indirect.sky) share = std::min(1.0f, share);
}

double Transport::bytes() const {
  return fine_->bytes() + coarse_->bytes() + from_fine_->bytes() + from_coarse_->bytes() +
         (close_ ? close_->bytes() : 0) +
         static_cast<double>(coarse_->size()) *
             (kBytesACoarse + kBytesABounce * std::max(bounces_, 2)) +
         (blend_ ? blend_->bytes() + static_cast<double>(blend_->samples().size()) * kBytesAFine
                 : 0);
}

}  // namespace isolux
