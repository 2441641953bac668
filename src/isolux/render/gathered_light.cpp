#include "isolux/render/gathered_light.h"

#include "isolux/render/cosine_direction.h"

namespace isolux {
namespace {

// Makes sums over a sample's rays the light there.
class Slope {
 public:
  Slope(const SampleLinks& row, Vec3 normal)
      : share_(1 / static_cast<float>(row.rays)),
        all_across_(static_cast<float>(row.all_tilt.across)),
        all_along_(static_cast<float>(row.all_tilt.along)) {
    constexpr double kGrowth = 1.25;
    const TangentFrame frame(normal);
    const double growth = kGrowth * LinkTilt::kStep / row.rays;
    across_ = as_float(growth * frame.across);
    along_ = as_float(growth * frame.along);
  }

  SlopedLight of(float light, float across, float along) const {
    const float mean = light * share_;
    const float x = across - all_across_ * mean, y = along - all_along_ * mean;
    return {
        mean,
        {x * across_.x + y * along_.x, x * across_.y + y * along_.y, x * across_.z + y * along_.z}};
  }

 private:
  float share_, all_across_, all_along_;
  Vec3f across_, along_;
};

}  // namespace

std::array<float, SentLight::kMost> gathered_light(const SampleLinks& row, const SentLight& sent) {
  std::array<float, SentLight::kMost> light{};
  if (row.rays == 0) return light;
  const LinkSums sums = sum_links(row.links, sent);
  for (std::size_t c = 0; c < sent.channels; ++c) {
    light[c] =
        (sums.light[c] + static_cast<float>(row.sky) * sent.sky[c]) / static_cast<float>(row.rays);
  }
  return light;
}

namespace {

// What is left of the sums over all links without those to what is close.
void take_close(const SampleLinks& row, const SentLight& sent, LinkSums& sums) {
  for (const std::uint16_t n : row.close) {
    const LinkSums one = sum_links_plainly({&row.links[n], 1}, sent);
    for (std::size_t c = 0; c < sent.channels; ++c) {
      sums.light[c] -= one.light[c];
      sums.across[c] -= one.across[c];
      sums.along[c] -= one.along[c];
    }
  }
}

void make_sloped(const SampleLinks& row, const LinkSums& sums, const SentLight& sent, Vec3 normal,
                 SlopedLight* to) {
  const Slope slope(row, normal);
  for (std::size_t c = 0; c < sent.channels; ++c) {
    const auto with_sky = [&](float of_links, std::int32_t of_sky) {
      return of_links + static_cast<float>(of_sky) * sent.sky[c];
    };
    to[c] =
        slope.of(with_sky(sums.light[c], row.sky), with_sky(sums.across[c], row.sky_tilt.across),
                 with_sky(sums.along[c], row.sky_tilt.along));
  }
}

}  // namespace

void gather_sloped(const SampleLinks& row, const SentLight& sent, Vec3 normal, SlopedLight* to) {
  if (row.rays == 0) {
    std::fill_n(to, sent.channels, SlopedLight{});
    return;
  }
  make_sloped(row, sum_links(row.links, sent), sent, normal, to);
}

void gather_further(const SampleLinks& row, const SentLight& sent, Vec3 normal, SlopedLight* to) {
  if (row.rays == 0) {
    std::fill_n(to, sent.channels, SlopedLight{});
    return;
  }
  LinkSums sums = sum_links(row.links, sent);
  take_close(row, sent, sums);
  make_sloped(row, sums, sent, normal, to);
}

SlopedLight close_share(const SampleLinks& row, Vec3 normal) {
  if (row.close.empty()) return {};
  float across = 0, along = 0;
  for (const std::uint16_t n : row.close) {
    across += row.links[n].across;
    along += row.links[n].along;
  }
  return Slope(row, normal).of(static_cast<float>(row.close.size()), across, along);
}

SlopedLight sloped_sky(const SampleLinks& row, Vec3 normal) {
  if (row.rays == 0) return {};
  return Slope(row, normal)
      .of(static_cast<float>(row.sky), static_cast<float>(row.sky_tilt.across),
          static_cast<float>(row.sky_tilt.along));
}

}  // namespace isolux
