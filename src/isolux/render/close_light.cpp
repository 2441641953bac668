#include "isolux/render/close_light.h"

#include <algorithm>
#include <cmath>

#include "isolux/base/exact_math.h"
#include "isolux/base/parallel.h"
#include "isolux/mesh/mesh_attributes.h"
#include "isolux/render/cosine_direction.h"

namespace isolux {
namespace {

constexpr int kPixels = SurfaceBuffer::kTilePixels;
constexpr std::uint32_t kSeed = 0xc105e;
// Of a pixel at most; and sets of directions, one for each place in a block.
constexpr std::size_t kMostRays = 512, kSets = SurfaceBuffer::kBlockPixels;
// Of a picture: more pixels get fewer each, but always a packet.
constexpr double kMostOfAll = 1 << 25;
// Tiles that are shot from between two questions whether to stop.
constexpr std::size_t kTilesAtOnce = 64, kTilesToLight = 32;
// Where samples see next to nothing that is not close, what else they see is not blown up.
constexpr float kMostFurther = 4;

// Evenly by the cosine about z, as what is close mostly lies low.
Vec3 low_direction(UnitPoint p) {
  const double radius = std::sqrt(1 - p.u * p.u), angle = 2 * exact::kPi * p.v;
  return {radius * exact::cos(angle), radius * exact::sin(angle), p.u};
}

// Of a pixel. The more is close the more of E it makes, and the more of its noise.
std::size_t rays_for(float close) {
  if (close <= 0) return 0;
  return close < 0.005f ? 64 : close < 0.03f ? 128 : kMostRays;
}

}  // namespace

CloseLight::CloseLight(const LinkTracer& tracer, const SceneSurfaces& surfaces,
                       const SurfaceSamples& from, const SurfaceBuffer& buffer,
                       const Camera& camera, std::vector<float> close)
    : surfaces_(surfaces),
      from_(from),
      buffer_(buffer),
      tracer_(tracer),
      camera_(camera),
      close_(std::move(close)),
      tiles_(buffer.hits.size()) {
  for (std::uint32_t n = 0; n < kSets * kMostRays; ++n) {
    directions_.push_back(low_direction(sobol_point(n, kSeed)));
  }
  for (;; ++halvings_) {
    rays_ = 0;
    for (const float share : close_) rays_ += static_cast<double>(rays_of(share));
    if (rays_ <= kMostOfAll || kMostRays >> halvings_ <= LinkRays::kLanes) break;
  }
}

std::size_t CloseLight::rays_of(float close) const {
  const std::size_t rays = rays_for(close);
  return rays == 0 ? 0 : std::max<std::size_t>(LinkRays::kLanes, rays >> halvings_);
}

// What the rays of one tile's pixels meet.
class CloseLight::Shooter {
 public:
  explicit Shooter(const CloseLight& light) : light_(light) {}

  void shoot(std::size_t index, Tile& tile) {
    const std::size_t begin = index * kPixels;
    const float* const close = &light_.close_[begin];
    if (std::all_of(close, close + kPixels, [](float share) { return share <= 0; })) return;
    tile.further.assign(kPixels, 1.0f);
    for (std::size_t n = 0; n < kPixels; ++n) {
      if (close[n] > 0) {
        const float found = shoot_from(begin + n, light_.rays_of(close[n]), tile);
        tile.further[n] = std::min(kMostFurther, (1 - found) / std::max(1e-6f, 1 - close[n]));
      }
      tile.ends.push_back(static_cast<std::uint16_t>(tile.links.size()));
    }
    tile.links.shrink_to_fit();
  }

 private:
  // Returns the share of directions in which something is close.
  float shoot_from(std::size_t place, std::size_t count, Tile& tile) {
    const SurfaceSample sample = light_.buffer_.sample(place);
    const auto [x, y] = light_.buffer_.pixel(place);
    const Ray eye_ray = light_.camera_.ray(x, y);
    const PreparedSurface& surface = light_.surfaces_.at(sample.surface);
    const Vec3 position = eye_ray.at(sample.depth_mm), normal = sample.normal();
    Vec3 outward = surface.true_normal(position, sample.point).value_or(normal);
    // A triangle's normal is taken to be on the side of its vertices' normals.
    if (surface.mesh() && dot(outward, shading_normal(*surface.mesh(), sample.point)) < 0) {
      outward = -outward;
    }
    const bool is_inside = dot(outward, eye_ray.direction) > 0;
    const Vec3 above = is_inside ? -outward : outward;
    const Vec3 start = position + LinkTracer::kOff * surface.step_mm() * above;
    const TangentFrame frame(normal);
    const Vec3* const directions = &light_.directions_[place % kSets * kMostRays];
    double cosines = 0;
    const auto reach = static_cast<float>(light_.from_.close_mm(sample.surface));
    const std::size_t begin = tile.links.size();
    for (std::size_t number = 0; number < count; number += LinkRays::kCount) {
      rays_.count = static_cast<int>(std::min<std::size_t>(LinkRays::kCount, count - number));
      for (int n = 0; n < rays_.count; ++n) {
        const std::size_t at = number + static_cast<std::size_t>(n);
        rays_.reach_mm[n] = reach;
        rays_.surface[n] = sample.surface;
        rays_.inside[n] = is_inside;
        rays_.seed[n] = static_cast<std::uint32_t>(place);
        rays_.number[n] = static_cast<std::uint32_t>(at);
        cosines += directions[at].z;
        rays_.set(n, {start, kept_above(frame.world(directions[at]), above)});
      }
      light_.tracer_.trace(rays_);
      for (int n = 0; n < rays_.count; ++n) {
        if (rays_.to[n] >= LinkRays::kDark) continue;
        const Vec3& direction = directions[number + static_cast<std::size_t>(n)];
        tile.links.push_back({rays_.to[n], static_cast<float>(direction.z)});
      }
    }
    return joined(tile.links, begin, static_cast<float>(1 / cosines));
  }

  // Makes one link of those from `begin` on that lead to the same sample, and shares of their
  // cosines; returns the sum of shares.
  static float joined(std::vector<CloseLink>& links, std::size_t begin, float share) {
    std::stable_sort(links.begin() + static_cast<std::ptrdiff_t>(begin), links.end(),
                     [](const CloseLink& a, const CloseLink& b) { return a.to < b.to; });
    std::size_t end = begin;
    float sum = 0;
    for (std::size_t n = begin; n < links.size(); ++n) {
      links[n].share *= share;
      sum += links[n].share;
      if (end > begin && links[end - 1].to == links[n].to) {
        links[end - 1].share += links[n].share;
      } else {
        links[end++] = links[n];
      }
    }
    links.resize(end);
    return std::min(1.0f, sum);
  }

  const CloseLight& light_;
  LinkRays rays_;
};

bool CloseLight::shoot(const std::function<bool()>& stop) {
  while (!is_whole()) {
    if (stop && stop()) return false;
    const std::size_t count = std::min(kTilesAtOnce, tiles_.size() - shot_);
    parallel_for(count, 1, [&](std::size_t begin, std::size_t end) {
      Shooter shooter(*this);
      for (std::size_t n = begin; n < end; ++n) shooter.shoot(shot_ + n, tiles_[shot_ + n]);
    });
    shot_ += count;
  }
  return true;
}

double CloseLight::done() const {
  return tiles_.empty() ? 1 : static_cast<double>(shot_) / static_cast<double>(tiles_.size());
}

void CloseLight::add(const SentLight& sent, RgbLayer& pixels) const {
  parallel_for(tiles_.size(), kTilesToLight, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) {
      const Tile& tile = tiles_[t];
      std::size_t link = 0;
      for (std::size_t n = 0; n < tile.ends.size(); ++n) {
        std::array<float, SentLight::kMost> sum{};
        for (; link < tile.ends[n]; ++link) {
          const auto& [to, share] = tile.links[link];
          for (std::size_t c = 0; c < sent.channels; ++c) {
            sum[c] += share * sent.of_samples[sent.channels * to + c];
          }
        }
        for (std::size_t c = 0; c < SentLight::kMost; ++c) {
          float& light = pixels.channel(static_cast<int>(c))[t * kPixels + n];
          light = tile.further[n] * light + sum[std::min(c, sent.channels - 1)];
        }
      }
    }
  });
}

void CloseLight::dim_sky(std::vector<float>& sky) const {
  parallel_for(tiles_.size(), kTilesToLight, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) {
      const Tile& tile = tiles_[t];
      for (std::size_t n = 0; n < tile.further.size(); ++n) {
        sky[t * kPixels + n] *= tile.further[n];
      }
    }
  });
}

double CloseLight::bytes() const {
  double sum = static_cast<double>(close_.size() * sizeof(float) + tiles_.size() * sizeof(Tile));
  for (const Tile& tile : tiles_) {
    sum += static_cast<double>(tile.links.capacity() * sizeof(CloseLink) +
                               tile.further.capacity() * sizeof(float) +
                               tile.ends.capacity() * sizeof(std::uint16_t));
  }
  return sum;
}

}  // namespace isolux
