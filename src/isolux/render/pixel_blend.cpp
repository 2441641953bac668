#include "isolux/render/pixel_blend.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "isolux/base/parallel.h"
#include "isolux/mesh/mesh_attributes.h"

namespace isolux {
namespace {

constexpr std::size_t kTilesAPiece = 32;
constexpr int kMost = 16;  // points at once

// How far from a point's tangent plane samples may lie, in edges of blocks.
constexpr float kThickness = 0.5f;
// The same for another sheet of a mesh: where two of them lie in one plane, the seam is not seen.
constexpr float kOtherThickness = 0.02f;
// Points go together where they are no further apart.
constexpr float kTogether = 1;

// Points that are near to each other, on one surface.
struct Points {
  int count = 0;
  std::int32_t surface = 0;
  std::uint32_t sheet = 0;
  std::array<float, kMost> x, y, z;                       // in blocks, from `origin`
  std::array<float, kMost> normal_x, normal_y, normal_z;  // outside
  std::array<float, kMost> across_x, across_y, across_z;  // the same as a covector in blocks
  std::array<SeenSide, kMost> side;
  Vec3 origin;
};

using Weights = std::array<float, kMost>;

// (1 - a)^2 where a < 1.
inline float falling(float a) {
  const float rest = std::max(0.0f, 1 - a);
  return rest * rest;
}

// The weights of a site's outside in the points, without regard to their side.
Weights weights_of(const SampleSite& site, const Points& points) {
  const auto ox = static_cast<float>(site.in_blocks.x - points.origin.x),
             oy = static_cast<float>(site.in_blocks.y - points.origin.y),
             oz = static_cast<float>(site.in_blocks.z - points.origin.z);
  constexpr float kScale = 1 / (PixelBlend::kReach * PixelBlend::kReach);
  const float thickness = site.sheet == points.sheet ? kThickness : kOtherThickness;
  const float plane_scale = 1 / (thickness * thickness);
  Weights weights;
  for (std::size_t n = 0; n < kMost; ++n) {
    const float dx = ox - points.x[n], dy = oy - points.y[n], dz = oz - points.z[n];
    const float off = dx * points.across_x[n] + dy * points.across_y[n] + dz * points.across_z[n];
    const float likeness =
        std::max(0.0f, site.normal.x * points.normal_x[n] + site.normal.y * points.normal_y[n] +
                           site.normal.z * points.normal_z[n]);
    const float square = likeness * likeness;
    weights[n] = falling(kScale * (dx * dx + dy * dy + dz * dz)) *
                 falling(plane_scale * off * off) * square * square * square * square;
  }
  return weights;
}

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
  struct Weighed {
    std::uint32_t sample;
    Weights weights;
  };
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
      std::array<std::size_t, kBlock> members;
      Points points;
      points.surface = buffer_.surface[place + first];
      points.sheet = all[first].sheet;
      points.origin = all[first].in_blocks;
      for (std::uint32_t rest = hits; rest != 0; rest &= rest - 1) {
        const auto n = static_cast<std::size_t>(std::countr_zero(rest));
        const Vec3 from_origin = all[n].in_blocks - points.origin;
        if (buffer_.surface[place + n] != points.surface || all[n].sheet != points.sheet ||
            length(from_origin) > kTogether) {
          continue;
        }
        members[static_cast<std::size_t>(points.count)] = n;
        add(points, all[n]);
        hits &= ~(1u << n);
      }
      add_shares(points, members, piece);
    }
  }

  void find_point(const FurtherPoint& point, Piece& piece) {
    const auto& [nx, ny, nz] = point.normal;
    const auto& [ex, ey, ez] = point.to_eye;
    Points points;
    points.surface = point.surface;
    const Met at = met(point.surface, point.position, {nx, ny, nz}, {ex, ey, ez}, point.point);
    points.sheet = at.sheet;
    points.origin = at.in_blocks;
    add(points, at);
    weigh(points);
    for (const Weighed& weighed : weighed_) {
      piece.points.push_back({weighed.sample, weighed.weights[0] / sums_[0]});
    }
  }

  void add(Points& points, const Met& at) const {
    const auto n = static_cast<std::size_t>(points.count++);
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
    points.side[n] = at.side;
  }

  // Finds `weighed_` and their `sums_`, which are not 0 where a sample is anywhere near.
  void weigh(Points& points) {
    weighed_.clear();
    sums_.fill(0);
    const auto count = static_cast<std::size_t>(points.count);
    // What lies beyond the last point repeats it.
    for (std::size_t n = count; n < kMost; ++n) {
      for (auto* of : {&points.x, &points.y, &points.z, &points.normal_x, &points.normal_y,
                       &points.normal_z, &points.across_x, &points.across_y, &points.across_z}) {
        (*of)[n] = (*of)[count - 1];
      }
      points.side[n] = points.side[count - 1];
    }
    BlockIndex low, high;
    const auto range = [&](const std::array<float, kMost>& of, double origin, std::size_t axis) {
      const auto [least, most] = std::ranges::minmax(of);
      low[axis] =
          static_cast<std::int32_t>(std::floor(origin + static_cast<double>(least - kReach)));
      high[axis] =
          static_cast<std::int32_t>(std::floor(origin + static_cast<double>(most + kReach)));
    };
    range(points.x, points.origin.x, 0);
    range(points.y, points.origin.y, 1);
    range(points.z, points.origin.z, 2);
    samples_.each_site(points.surface, low, high, [&](std::uint32_t site) {
      const Weights weights = weights_of(samples_.sites()[site], points);
      if (std::ranges::max(weights) <= 0) return;
      for (std::size_t n = 0; n < count; ++n) {
        if (weights[n] == 0) continue;
        weighed_of(samples_.sample(site, points.side[n])).weights[n] = weights[n];
        sums_[n] += weights[n];
      }
    });
    constexpr float kLeast = 1e-3f;
    for (std::size_t n = 0; n < count; ++n) {
      if (sums_[n] < kLeast) stand_in(points, n, kLeast);
    }
  }

  // The entry of a sample, one of the last four if there is one: those of a site come together.
  Weighed& weighed_of(std::uint32_t sample) {
    const std::size_t first = weighed_.size() - std::min<std::size_t>(4, weighed_.size());
    for (std::size_t n = first; n < weighed_.size(); ++n) {
      if (weighed_[n].sample == sample) return weighed_[n];
    }
    return weighed_.emplace_back(Weighed{sample, {}});
  }

  // Where nothing near is like a point, what is least unlike it stands in for the rest.
  void stand_in(const Points& points, std::size_t n, float least) {
    const Vec3 at = points.origin + Vec3{points.x[n], points.y[n], points.z[n]};
    const Vec3 outward{points.normal_x[n], points.normal_y[n], points.normal_z[n]};
    const std::uint32_t sample =
        samples_.find_in_blocks(points.surface, at, points.sheet, outward, points.side[n]);
    if (sample == SurfaceSamples::kNone) return;
    weighed_of(sample).weights[n] += least - sums_[n];
    sums_[n] = least;
  }

  void add_shares(Points& points, const std::array<std::size_t, kBlock>& members, Piece& piece) {
    weigh(points);
    const auto count = static_cast<std::size_t>(points.count);
    std::array<int, kBlock> left;
    std::array<std::size_t, kBlock> greatest{};
    left.fill(BlendShare::kWhole);
    const std::size_t begin = piece.shares.size();
    for (const Weighed& weighed : weighed_) {
      BlendShare share{weighed.sample, {}};
      bool counts = false;
      for (std::size_t n = 0; n < count; ++n) {
        if (sums_[n] == 0) continue;
        const auto weight = static_cast<std::uint16_t>(weighed.weights[n] / sums_[n] *
                                                       BlendShare::kWhole);  // rounds down
        share.weight[members[n]] = weight;
        left[n] -= weight;
        counts = counts || weight > 0;
      }
      if (!counts) continue;
      const std::size_t at = piece.shares.size();
      piece.shares.push_back(share);
      for (std::size_t n = 0; n < count; ++n) {
        if (greatest[n] == 0 ||
            share.weight[members[n]] > piece.shares[begin + greatest[n] - 1].weight[members[n]]) {
          greatest[n] = at - begin + 1;
        }
      }
    }
    // What rounding has left belongs to the greatest.
    for (std::size_t n = 0; n < count; ++n) {
      if (greatest[n] == 0) continue;
      std::uint16_t& weight = piece.shares[begin + greatest[n] - 1].weight[members[n]];
      weight = static_cast<std::uint16_t>(weight + left[n]);
    }
  }

  const Scene& scene_;
  const SceneSurfaces& surfaces_;
  const SurfaceSamples& samples_;
  const SurfaceBuffer& buffer_;
  std::vector<Weighed> weighed_;
  Weights sums_;
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
