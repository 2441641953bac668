#include "isolux/render/pixel_blend.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "isolux/base/parallel.h"
#include "isolux/mesh/mesh_attributes.h"
#include "isolux/render/site_weights.h"

namespace isolux {
namespace {

constexpr std::size_t kTilesAPiece = 32;
// Points go together where they are no further apart, in edges of blocks.
constexpr float kTogether = 1;

using Floats = BlendPoints::Floats;
constexpr std::size_t kMost = BlendPoints::kCount;

}  // namespace

class PixelBlend::Finder {
 public:
  Finder(const Scene& scene, const SceneSurfaces& surfaces, const SurfaceSamples& samples,
         const SurfaceBuffer& buffer)
      : scene_(scene), surfaces_(surfaces), samples_(samples), buffer_(buffer) {}

  void find(std::size_t tile, Piece& piece) {
    for (std::size_t block = 0; block < 4; ++block) {
      const auto hits = static_cast<std::uint32_t>(buffer_.hits[tile] >> (16 * block) & 0xFFFF);
      find_block(64 * tile + 16 * block, hits, piece);
      piece.ends.push_back(static_cast<std::uint32_t>(piece.shares.size()));
    }
    if (buffer_.further.empty()) return;
    for (const FurtherPoint& point : buffer_.further[tile]) {
      if (point.surface != FurtherPoint::kBackground) find_point(point, piece);
      piece.point_ends.push_back(static_cast<std::uint32_t>(piece.points.size()));
    }
    piece.tile_ends.push_back(static_cast<std::uint32_t>(piece.point_ends.size()));
  }

 private:
  static std::size_t number_of(SeenSide side) {
    return (side.inside ? 2u : 0u) + (side.flipped ? 1u : 0u);
  }
  static SeenSide side_of(std::size_t number) { return {(number & 2) != 0, (number & 1) != 0}; }

  struct Met {
    Vec3 in_blocks;
    Vec3 outward;
    SeenSide side;
    std::uint32_t sheet;
  };

  Met met(std::int32_t surface, Vec3 position, Vec3 normal, Vec3 to_eye,
          const MeshPoint& point) const {
    const PreparedSurface& of = surfaces_.at(surface);
    const Vec3 out = of.mesh() ? shading_normal(*of.mesh(), point)
                               : of.true_normal(position, point).value_or(normal);
    const bool turned = dot(out, normal) < 0;
    const Vec3 outward = turned ? -normal : normal;
    const bool inside =
        of.mesh() ? is_inside(of, position, point, outward, -to_eye) : dot(out, to_eye) < 0;
    return {samples_.in_blocks(surface, position),
            outward,
            {inside, turned != inside},
            samples_.sheet(surface, point)};
  }

  void find_block(std::size_t place, std::uint32_t hits, Piece& piece) {
    std::array<Met, kBlock> all;
    for (std::uint32_t rest = hits; rest != 0; rest &= rest - 1) {
      const auto n = static_cast<std::size_t>(std::countr_zero(rest));
      const auto [x, y] = buffer_.pixel(place + n);
      const Ray ray = scene_.camera->ray(x, y);
      const SurfaceSample sample = buffer_.sample(place + n);
      all[n] = met(sample.surface, ray.at(sample.depth_mm), sample.normal(), -ray.direction,
                   sample.point);
    }
    while (hits != 0) {
      const auto first = static_cast<std::size_t>(std::countr_zero(hits));
      BlendPoints points;
      points.surface = buffer_.surface[place + first];
      points.sheet = all[first].sheet;
      points.origin = all[first].in_blocks;
      of_side_ = {};
      for (std::uint32_t rest = hits; rest != 0; rest &= rest - 1) {
        const auto n = static_cast<std::size_t>(std::countr_zero(rest));
        const Vec3 from_origin = all[n].in_blocks - points.origin;
        if (buffer_.surface[place + n] != points.surface || all[n].sheet != points.sheet ||
            length(from_origin) > kTogether) {
          continue;
        }
        set(points, n, all[n]);
      }
      hits &= ~points.mask;
      add_shares(points, piece);
    }
  }

  void find_point(const FurtherPoint& point, Piece& piece) {
    const auto& [nx, ny, nz] = point.normal;
    const auto& [ex, ey, ez] = point.to_eye;
    BlendPoints points;
    points.surface = point.surface;
    const Met at = met(point.surface, point.position, {nx, ny, nz}, {ex, ey, ez}, point.point);
    points.sheet = at.sheet;
    points.origin = at.in_blocks;
    of_side_ = {};
    set(points, 0, at);
    weigh(points);
    for (const SiteWeights& sample : samples_found_) {
      piece.points.push_back({sample.which, sample.weight[0] / sums_[0]});
    }
  }

  void set(BlendPoints& points, std::size_t n, const Met& at) {
    const Vec3f from_origin = as_float(at.in_blocks - points.origin);
    points.x[n] = from_origin.x;
    points.y[n] = from_origin.y;
    points.z[n] = from_origin.z;
    const Vec3f outward = as_float(at.outward);
    points.normal_x[n] = outward.x;
    points.normal_y[n] = outward.y;
    points.normal_z[n] = outward.z;
    const Vec3f across = as_float(samples_.normal_in_blocks(points.surface, at.outward));
    points.across_x[n] = across.x;
    points.across_y[n] = across.y;
    points.across_z[n] = across.z;
    points.mask |= 1u << n;
    of_side_[number_of(at.side)] |= 1u << n;
  }

  // Finds the samples that count, and the sums of their weights, which are not 0 where a sample is
  // anywhere near.
  void weigh(BlendPoints& points) {
    const auto first = static_cast<std::size_t>(std::countr_zero(points.mask));
    for (std::uint32_t rest = 0xFFFF & ~points.mask; rest != 0; rest &= rest - 1) {
      const auto n = static_cast<std::size_t>(std::countr_zero(rest));
      for (auto* of : {&points.x, &points.y, &points.z, &points.normal_x, &points.normal_y,
                       &points.normal_z, &points.across_x, &points.across_y, &points.across_z}) {
        (*of)[n] = (*of)[first];
      }
    }
    BlockIndex low, high;
    const auto range = [&](const Floats& of, double origin, std::size_t axis) {
      const auto [least, most] = std::ranges::minmax(of);
      low[axis] =
          static_cast<std::int32_t>(std::floor(origin + static_cast<double>(least - kBlendReach)));
      high[axis] =
          static_cast<std::int32_t>(std::floor(origin + static_cast<double>(most + kBlendReach)));
    };
    range(points.x, points.origin.x, 0);
    range(points.y, points.origin.y, 1);
    range(points.z, points.origin.z, 2);
    near_.clear();
    samples_.each_site(points.surface, low, high,
                       [&](std::uint32_t site) { near_.push_back(site); });
    sites_found_.clear();
    weigh_sites(points, samples_.sites().data(), near_, sites_found_);
    samples_found_.clear();
    sums_.fill(0);
    for (const SiteWeights& site : sites_found_) {
      for (std::size_t side = 0; side < of_side_.size(); ++side) {
        const std::uint32_t lanes = site.lanes & of_side_[side];
        if (lanes != 0) add(samples_.sample(site.which, side_of(side)), lanes, site.weight);
      }
    }
    constexpr float kLeast = 1e-3f;
    for (std::uint32_t rest = points.mask; rest != 0; rest &= rest - 1) {
      const auto n = static_cast<std::size_t>(std::countr_zero(rest));
      if (sums_[n] < kLeast) stand_in(points, n, kLeast);
    }
  }

  void add(std::uint32_t sample, std::uint32_t lanes, const Floats& weight) {
    SiteWeights& to = samples_found_.emplace_back(SiteWeights{sample, lanes, weight});
    for (std::size_t n = 0; n < kMost; ++n) {
      to.weight[n] = (lanes >> n & 1) != 0 ? weight[n] : 0;
      sums_[n] += to.weight[n];
    }
  }

  // Where nothing near is like a point, what is least unlike it stands in for the rest.
  void stand_in(const BlendPoints& points, std::size_t n, float least) {
    const Vec3 at = points.origin + Vec3{points.x[n], points.y[n], points.z[n]};
    const Vec3 outward{points.normal_x[n], points.normal_y[n], points.normal_z[n]};
    const auto side =
        std::ranges::find_if(of_side_, [n](std::uint32_t lanes) { return (lanes >> n & 1) != 0; });
    const std::uint32_t sample =
        samples_.find_in_blocks(points.surface, at, points.sheet, outward,
                                side_of(static_cast<std::size_t>(side - of_side_.begin())));
    if (sample == SurfaceSamples::kNone) return;
    Floats weight;
    weight[n] = least - sums_[n];
    add(sample, 1u << n, weight);
  }

  void add_shares(BlendPoints& points, Piece& piece) {
    weigh(points);
    Floats scale, most{};
    std::array<std::int32_t, kMost> left{}, greatest{};
    for (std::size_t n = 0; n < kMost; ++n)
      scale[n] = sums_[n] > 0 ? BlendShare::kWhole / sums_[n] : 0;
    for (std::size_t n = 0; n < kMost; ++n) left[n] = sums_[n] > 0 ? BlendShare::kWhole : 0;
    const std::size_t begin = piece.shares.size();
    for (const SiteWeights& sample : samples_found_) {
      BlendShare& share = piece.shares.emplace_back(BlendShare{sample.which, {}});
      const auto number = static_cast<std::int32_t>(piece.shares.size() - 1 - begin);
      int all = 0;
      for (std::size_t n = 0; n < kMost; ++n) {
        const auto part = static_cast<std::int32_t>(sample.weight[n] * scale[n]);  // rounds down
        share.weight[n] = static_cast<std::uint16_t>(part);
        left[n] -= part;
        all |= part;
        greatest[n] = sample.weight[n] > most[n] ? number : greatest[n];
        most[n] = std::max(most[n], sample.weight[n]);
      }
      if (all == 0) piece.shares.pop_back();
    }
    // What rounding has left belongs to the greatest.
    for (std::uint32_t rest = points.mask; rest != 0; rest &= rest - 1) {
      const auto n = static_cast<std::size_t>(std::countr_zero(rest));
      if (left[n] == 0) continue;
      std::uint16_t& weight = piece.shares[begin + static_cast<std::size_t>(greatest[n])].weight[n];
      weight = static_cast<std::uint16_t>(weight + left[n]);
    }
  }

  const Scene& scene_;
  const SceneSurfaces& surfaces_;
  const SurfaceSamples& samples_;
  const SurfaceBuffer& buffer_;
  std::array<std::uint32_t, 4> of_side_;  // lanes of points that are seen from there
  std::vector<std::uint32_t> near_;
  std::vector<SiteWeights> sites_found_, samples_found_;
  Floats sums_;
};

PixelBlend::PixelBlend(const Scene& scene, const SceneSurfaces& surfaces,
                       const SurfaceSamples& samples, const SurfaceBuffer& buffer)
    : pieces_((buffer.hits.size() + kTilesAPiece - 1) / kTilesAPiece) {
  parallel_for(pieces_.size(), 1, [&](std::size_t begin, std::size_t end) {
    Finder finder(scene, surfaces, samples, buffer);
    for (std::size_t n = begin; n < end; ++n) {
      const std::size_t last = std::min(buffer.hits.size(), (n + 1) * kTilesAPiece);
      for (std::size_t tile = n * kTilesAPiece; tile < last; ++tile) {
        finder.find(tile, pieces_[n]);
      }
    }
  });
  // What weights are for becomes a number in samples().
  constexpr std::uint32_t kUnused = ~0u;
  std::vector<std::uint32_t> numbers(samples.size(), kUnused);
  const auto each_sample = [&](const auto& body) {
    for (Piece& piece : pieces_) {
      for (BlendShare& share : piece.shares) body(share.sample);
      for (Point& point : piece.points) body(point.sample);
    }
  };
  each_sample([&](std::uint32_t& sample) { numbers[sample] = 0; });
  for (std::uint32_t n = 0; n < samples.size(); ++n) {
    if (numbers[n] == kUnused) continue;
    numbers[n] = static_cast<std::uint32_t>(samples_.size());
    samples_.push_back(n);
  }
  each_sample([&](std::uint32_t& sample) { sample = numbers[sample]; });
}

std::size_t PixelBlend::channels_of(const std::vector<SlopedLight>& of_samples) const {
  return samples_.empty() ? 1 : of_samples.size() / samples_.size();
}

void PixelBlend::pixels(const std::vector<SlopedLight>& of_samples, const SurfaceBuffer& buffer,
                        std::span<float* const> channels) const {
  const std::size_t lit = channels_of(of_samples);
  parallel_for(pieces_.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t n = first; n < last; ++n) {
      const Piece& piece = pieces_[n];
      std::size_t begin = 0;
      for (std::size_t block = 0; block < piece.ends.size(); ++block) {
        const std::size_t place = (kTilesAPiece * 4 * n + block) * kBlock;
        float* to[3];
        for (std::size_t c = 0; c < lit; ++c) to[c] = channels[c] + place;
        const std::size_t end = piece.ends[block];
        blend({piece.shares.data() + begin, end - begin}, of_samples.data(),
              {&buffer.normal_x[place], &buffer.normal_y[place], &buffer.normal_z[place]},
              {to, lit});
        begin = end;
        for (std::size_t c = lit; c < channels.size(); ++c) {
          std::copy_n(to[0], kBlock, channels[c] + place);
        }
      }
    }
  });
}

std::vector<std::vector<std::array<float, 3>>> PixelBlend::further(
    const std::vector<SlopedLight>& of_samples, const SurfaceBuffer& buffer) const {
  const std::size_t channels = channels_of(of_samples);
  std::vector<std::vector<std::array<float, 3>>> tiles;
  for (const Piece& piece : pieces_) {
    std::size_t point = 0, share = 0;
    for (const std::uint32_t tile_end : piece.tile_ends) {
      const FurtherPoints& points = buffer.further[tiles.size()];
      auto& tile = tiles.emplace_back();
      for (; point < tile_end; ++point) {
        const auto& normal = points[tile.size()].normal;
        auto& sum = tile.emplace_back();
        for (; share < piece.point_ends[point]; ++share) {
          const SlopedLight* light = &of_samples[piece.points[share].sample * channels];
          for (std::size_t c = 0; c < sum.size(); ++c) {
            const auto& [mean, slope] = light[c % channels];
            const float turned =
                mean + normal[0] * slope[0] + normal[1] * slope[1] + normal[2] * slope[2];
            sum[c] += piece.points[share].weight * turned;
          }
        }
        for (float& channel : sum) channel = std::max(0.0f, channel);
      }
    }
  }
  return tiles;
}

double PixelBlend::bytes() const {
  double sum = 0;
  for (const Piece& piece : pieces_) {
    sum += static_cast<double>(piece.shares.capacity() * sizeof(BlendShare) +
                               piece.points.capacity() * sizeof(Point) +
                               (piece.ends.capacity() + piece.point_ends.capacity()) * 4);
  }
  return sum;
}

}  // namespace isolux
