#include "isolux/render/denoise.h"

#include <algorithm>
#include <array>
#include <utility>

#include "isolux/base/parallel.h"
#include "isolux/render/denoise_pass.h"

namespace isolux {
namespace denoising {

Plane::Plane(int width, int height, float value)
    : stride_((width + 2 * kMargin + kMostLanes - 1) / kMostLanes * kMostLanes) {
  const auto count = static_cast<std::size_t>(stride_ * (height + 2 * kMargin) + kMostLanes);
  values_ = hwy::AllocateAligned<float>(count);
  std::fill_n(values_.get(), count, value);
}

Rays::Rays(const Camera& camera)
    : is_orthographic(camera.is_orthographic()),
      pixel_size(static_cast<float>(camera.pixel_size())) {
  const RayFan fan = camera.fan();
  const RayFan::Plane& moves = is_orthographic ? fan.origin : fan.direction;
  for (int a = 0; a < 3; ++a) {
    first[a] = static_cast<float>(fan.direction.first[a]);
    along_x[a] = static_cast<float>(moves.along_x[a]);
    along_y[a] = static_cast<float>(moves.along_y[a]);
  }
}

namespace {

// What each level makes of a single bright pixel on an endless wall.
std::array<Gains, kLevels> endless_wall() {
  constexpr int kReach = 2 * kMargin, kWidth = 2 * kReach + 1;
  using Image = std::vector<double>;
  const auto index = [](int x, int y) {
    return static_cast<std::size_t>((y + kReach) * kWidth + x + kReach);
  };
  const auto energy = [](const Image& image) {
    double sum = 0;
    for (const double value : image) sum += value * value;
    return sum;
  };
  double taps = 0;
  for (const Tap& tap : kTaps) taps += tap.weight * tap.weight;
  std::array<Gains, kLevels> gains;
  Image level(kWidth * kWidth);
  level[index(0, 0)] = 1;
  for (int n = 0; n < kLevels; ++n) {
    Image next(level.size()), detail = level;
    const int step = 1 << n, within = kReach - 2 * step;
    for (int y = -within; y <= within; ++y) {
      for (int x = -within; x <= within; ++x) {
        for (const Tap& tap : kTaps) {
          next[index(x + step * tap.dx, y + step * tap.dy)] += tap.weight * level[index(x, y)];
        }
      }
    }
    for (std::size_t at = 0; at < detail.size(); ++at) detail[at] -= next[at];
    const double before = energy(level), after = energy(next);
    gains[static_cast<std::size_t>(n)] = {static_cast<float>(taps),
                                          static_cast<float>(after / (before * taps)),
                                          static_cast<float>(energy(detail) / (before - after))};
    level = std::move(next);
  }
  return gains;
}

// All rows, in such an order that those which have taps in common follow each other, and are still
// in the cache.
std::vector<int> by_neighbours(int height, int step) {
  std::vector<int> rows;
  for (int first = 0; first < step; ++first) {
    for (int y = first; y < height; y += step) rows.push_back(y);
  }
  return rows;
}

}  // namespace
}  // namespace denoising

using namespace denoising;

namespace {

constexpr std::size_t kRowsAPiece = 16;
// So many times its variance is what noise is taken for: it is not the same all over. More where
// all that is known of it is the finest detail.
constexpr float kStrength = 1.5f;
constexpr float kStrengthOfUnknown = 2;

// Calls body(begin, end) for pieces of all rows, on all threads.
template <typename Body>
void each_piece(int height, const Body& body) {
  parallel_for(static_cast<std::size_t>(height), kRowsAPiece,
               [&](std::size_t begin, std::size_t end) {
                 body(static_cast<int>(begin), static_cast<int>(end));
               });
}

}  // namespace

struct Denoiser::Planes {
  Guide guide;
  Colors levels[2], result;
  Plane variances[2], energies[2], noises[2];

  Planes(int w, int h)
      : guide(w, h),
        levels{{w, h}, {w, h}},
        result(w, h),
        variances{{w, h}, {w, h}},
        energies{{w, h}, {w, h}},
        noises{{w, h}, {w, h}} {}

  void load(const SurfaceBuffer& buffer, const std::vector<float>& variance, const RgbLayer& light,
            const Rays& rays);
  void filter(const Rays& rays, bool has_variance);
  void store(const SurfaceBuffer& buffer, RgbLayer& light) const;
};

void Denoiser::Planes::load(const SurfaceBuffer& buffer, const std::vector<float>& variance,
                            const RgbLayer& light, const Rays& rays) {
  each_piece(guide.height, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < guide.width; ++x) {
        const std::size_t place = buffer.at(x, y);
        const bool is_hit = buffer.is_hit(place);
        const float surface = is_hit ? static_cast<float>(buffer.surface[place]) : 0;
        guide.key.row(y)[x] =
            is_hit ? buffer.normal_x[place] + Guide::kApart * surface : Guide::kNothing;
        guide.normal_y.row(y)[x] = is_hit ? buffer.normal_y[place] : 0;
        guide.normal_z.row(y)[x] = is_hit ? buffer.normal_z[place] : 0;
        guide.depth.row(y)[x] = is_hit ? static_cast<float>(buffer.depth_mm[place]) : 1;
        variances[0].row(y)[x] = is_hit && !variance.empty() ? variance[place] : 0;
        for (int c = 0; c < 3; ++c) {
          levels[0].at(c).row(y)[x] = is_hit ? light.channel(c)[place] : 0;
        }
      }
    }
    flatten(rays, guide, begin, end);
  });
}

void Denoiser::Planes::filter(const Rays& rays, bool has_variance) {
  static const std::array<Gains, kLevels> gains = endless_wall();
  for (int n = 0; n <= kLevels; ++n) {
    const int now = n % 2, other = 1 - now;
    const bool is_first = n == 0, is_last = n == kLevels;
    const int level = std::min(n, kLevels - 1);
    const Pass pass{.guide = &guide,
                    .rays = &rays,
                    .step = 1 << level,
                    .gains = gains[static_cast<std::size_t>(level)],
                    .strength = has_variance ? kStrength : kStrengthOfUnknown,
                    .has_variance = has_variance,
                    .level = &levels[now],
                    .before = &levels[other],
                    .variance = &variances[now],
                    .energy = is_first ? nullptr : &energies[now],
                    .noise = is_first ? nullptr : &noises[now],
                    .next_variance = is_last ? nullptr : &variances[other],
                    .next_energy = is_last ? nullptr : &energies[other],
                    .next_noise = is_last ? nullptr : &noises[other],
                    .result_before = n == 1 ? &levels[other] : &result,
                    .result = &result};
    const std::vector<int> rows = by_neighbours(guide.height, pass.step);
    each_piece(guide.height, [&](int begin, int end) {
      denoising::filter(pass, {rows.data() + begin, rows.data() + end});
    });
  }
}

void Denoiser::Planes::store(const SurfaceBuffer& buffer, RgbLayer& light) const {
  each_piece(guide.height, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < guide.width; ++x) {
        const std::size_t place = buffer.at(x, y);
        if (!buffer.is_hit(place)) continue;
        for (int c = 0; c < 3; ++c) {
          light.channel(c)[place] = std::max(0.0f, result.at(c).row(y)[x]);
        }
      }
    }
  });
}

Denoiser::Denoiser() = default;
Denoiser::~Denoiser() = default;

void Denoiser::denoise(const Camera& camera, const SurfaceBuffer& buffer,
                       const std::vector<float>& variance, RgbLayer& light) {
  const int width = buffer.width(), height = buffer.height();
  if (!planes_ || planes_->guide.width != width || planes_->guide.height != height) {
    planes_ = std::make_unique<Planes>(width, height);
  }
  const Rays rays(camera);
  planes_->load(buffer, variance, light, rays);
  planes_->filter(rays, !variance.empty());
  planes_->store(buffer, light);
}

}  // namespace isolux
