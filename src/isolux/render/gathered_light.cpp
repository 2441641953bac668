#include "isolux/render/gathered_light.h"

#include "isolux/render/cosine_direction.h"

namespace isolux {
namespace {

// Light, and light times tilt.
struct Sums {
  SampleLight light{}, across{}, along{};

  void add(const SampleLight& from, float share, float tilt_across, float tilt_along) {
    for (std::size_t c = 0; c < from.size(); ++c) {
      light[c] += share * from[c];
      across[c] += tilt_across * from[c];
      along[c] += tilt_along * from[c];
    }
  }
  void add(const Sums& other) {
    for (std::size_t c = 0; c < light.size(); ++c) {
      light[c] += other.light[c];
      across[c] += other.across[c];
      along[c] += other.along[c];
    }
  }
};

inline Sums summed(const SampleLinks& row, const SampleLight* sent, const SampleLight& sky) {
  Sums even, odd;  // which do not wait for each other
  const auto add = [&](Sums& sums, const Link& link) {
    sums.add(sent[link.to], 1, link.across, link.along);
  };
  std::size_t n = 0;
  for (; n + 1 < row.links.size(); n += 2) {
    add(even, row.links[n]);
    add(odd, row.links[n + 1]);
  }
  if (n < row.links.size()) add(even, row.links[n]);
  odd.add(sky, static_cast<float>(row.sky), static_cast<float>(row.sky_tilt.across),
          static_cast<float>(row.sky_tilt.along));
  even.add(odd);
  return even;
}

SampleLight scaled(float by, SampleLight light) {
  for (float& channel : light) channel *= by;
  return light;
}

}  // namespace

SampleLight gathered_light(const SampleLinks& row, const SampleLight* sent,
                           const SampleLight& sky) {
  if (row.rays == 0) return {};
  return scaled(1 / static_cast<float>(row.rays), summed(row, sent, sky).light);
}

SlopedLight gathered_sloped(const SampleLinks& row, const SampleLight* sent, const SampleLight& sky,
                            Vec3 normal) {
  constexpr double kGrowth = 1.25;
  if (row.rays == 0) return {};
  const Sums sums = summed(row, sent, sky);
  SlopedLight light{scaled(1 / static_cast<float>(row.rays), sums.light), {}};
  const TangentFrame frame(normal);
  const double growth = kGrowth * LinkTilt::kStep / row.rays;
  const Vec3f across = as_float(growth * frame.across), along = as_float(growth * frame.along);
  const auto all_across = static_cast<float>(row.all_tilt.across),
             all_along = static_cast<float>(row.all_tilt.along);
  for (std::size_t c = 0; c < light.mean.size(); ++c) {
    const float x = sums.across[c] - all_across * light.mean[c];
    const float y = sums.along[c] - all_along * light.mean[c];
    light.slope[0][c] = x * across.x + y * along.x;
    light.slope[1][c] = x * across.y + y * along.y;
    light.slope[2][c] = x * across.z + y * along.z;
  }
  return light;
}

}  // namespace isolux
