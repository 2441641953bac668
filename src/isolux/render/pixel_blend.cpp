#include "isolux/render/pixel_blend.h"

#include <algorithm>
#include <atomic>
#include <bit>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

constexpr std::size_t kTilesAPiece = 32;
// Points are weighed together where they are no further apart, in edges of blocks: a block's, and
// those of a sketch.
constexpr double kTogether = 1, kSketchedTogether = 4;
// How far off a point's tangent plane its light is spread, in the same.
constexpr double kSpreadThickness = 0.75;
// The points of so many tiles are weighed together in a sketch.
constexpr std::size_t kSketchedTiles = BlendFinder::kCount / 4;
static_assert(kTilesAPiece % kSketchedTiles == 0);

// A channel of the light at sixteen points: mean, and slope by three axes.
using PointLights = std::array<BlendPoints::Floats, 4>;

// Adds what a sample counts at points to their light.
void add_share(const BlendShare& share, const SlopedLight* of_samples, std::size_t channels,
               PointLights* sums) {
  BlendPoints::Floats weight;
  for (std::size_t n = 0; n < weight.size(); ++n) {
    weight[n] = static_cast<float>(share.weight[n]) * (1.0f / BlendShare::kWhole);
  }
  for (std::size_t c = 0; c < channels; ++c) {
    const auto& [mean, slope] = of_samples[channels * share.sample + c];
    const float parts[4] = {mean, slope[0], slope[1], slope[2]};
    for (std::size_t part = 0; part < 4; ++part) {
      for (std::size_t n = 0; n < weight.size(); ++n) sums[c][part][n] += weight[n] * parts[part];
    }
  }
}

}  // namespace

PixelBlend::PixelBlend(const Scene& scene, const SceneSurfaces& surfaces,
                       const SurfaceSamples& samples, const SurfaceBuffer& buffer, Detail detail)
    : detail_(detail), pieces_((buffer.hits.size() + kTilesAPiece - 1) / kTilesAPiece) {
  parallel_for(pieces_.size(), 1, [&](std::size_t begin, std::size_t end) {
    BlendFinder finder(scene, surfaces, samples, buffer);
    for (std::size_t n = begin; n < end; ++n) {
      const std::size_t first = n * kTilesAPiece,
                        last = std::min(buffer.hits.size(), first + kTilesAPiece);
      if (detail == Detail::kSketch) find_sketch(buffer, first, last, finder, pieces_[n]);
      for (std::size_t tile = first; tile < last; ++tile) {
        if (detail == Detail::kWhole) find_tile(buffer, tile, finder, pieces_[n]);
        if (!buffer.further.empty()) find_further(buffer.further[tile], finder, pieces_[n]);
      }
    }
  });
  number_samples(samples.size());
  if (detail == Detail::kWhole) return;
  std::vector<double> thickness_mm;
  for (std::size_t s = 0; s < scene.surfaces.size(); ++s) {
    thickness_mm.push_back(kSpreadThickness * samples.block_mm(static_cast<std::int32_t>(s)));
  }
  spread_.emplace(*scene.camera, buffer, thickness_mm);
}

void PixelBlend::find_tile(const SurfaceBuffer& buffer, std::size_t tile, BlendFinder& finder,
                           Piece& piece) {
  for (std::size_t block = 0; block < 4; ++block) {
    const auto hits = static_cast<std::uint32_t>(buffer.hits[tile] >> (kBlock * block) & 0xFFFF);
    BlendFinder::Places places;
    for (std::size_t n = 0; n < kBlock; ++n) {
      places[n] = SurfaceBuffer::kTilePixels * tile + kBlock * block + n;
    }
    finder.find(places, hits, kTogether, piece.shares);
    piece.ends.push_back(static_cast<std::uint32_t>(piece.shares.size()));
  }
}

void PixelBlend::find_sketch(const SurfaceBuffer& buffer, std::size_t first, std::size_t last,
                             BlendFinder& finder, Piece& piece) {
  for (std::size_t tile = first; tile < last; tile += kSketchedTiles) {
    BlendFinder::Places places{};
    std::uint32_t mask = 0;
    for (std::size_t n = 0; n < kBlock && tile + n / 4 < last; ++n) {
      const auto place = LightSpread::place(buffer, tile + n / 4, n % 4);
      if (!place) continue;
      places[n] = *place;
      mask |= 1u << n;
    }
    finder.find(places, mask, kSketchedTogether, piece.shares);
    piece.ends.push_back(static_cast<std::uint32_t>(piece.shares.size()));
  }
}

void PixelBlend::find_further(const FurtherPoints& points, BlendFinder& finder, Piece& piece) {
  for (const FurtherPoint& point : points) {
    if (point.surface != FurtherPoint::kBackground) finder.find(point, piece.points);
    piece.point_ends.push_back(static_cast<std::uint32_t>(piece.points.size()));
  }
  piece.tile_ends.push_back(static_cast<std::uint32_t>(piece.point_ends.size()));
}

// What weights are for becomes a number in samples().
void PixelBlend::number_samples(std::size_t count) {
  const auto each_sample = [&](const auto& body) {
    parallel_for(pieces_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        for (BlendShare& share : pieces_[n].shares) body(share.sample);
        for (BlendWeight& point : pieces_[n].points) body(point.sample);
      }
    });
  };
  // A bit for each sample, and how many are used before each word of them.
  std::vector<std::uint64_t> used((count + 63) / 64);
  std::vector<std::uint32_t> before(used.size());
  each_sample([&](const std::uint32_t& sample) {
    const std::uint64_t bit = std::uint64_t{1} << sample % 64;
    const std::atomic_ref word(used[sample / 64]);
    if ((word.load(std::memory_order_relaxed) & bit) == 0) {
      word.fetch_or(bit, std::memory_order_relaxed);
    }
  });
  for (std::size_t n = 0; n < used.size(); ++n) {
    before[n] = static_cast<std::uint32_t>(samples_.size());
    for (std::uint64_t rest = used[n]; rest != 0; rest &= rest - 1) {
      samples_.push_back(static_cast<std::uint32_t>(64 * n) +
                         static_cast<std::uint32_t>(std::countr_zero(rest)));
    }
  }
  each_sample([&](std::uint32_t& sample) {
    const std::uint64_t below = (std::uint64_t{1} << sample % 64) - 1;
    sample =
        before[sample / 64] + static_cast<std::uint32_t>(std::popcount(used[sample / 64] & below));
  });
}

std::size_t PixelBlend::channels_of(const std::vector<SlopedLight>& of_samples) const {
  return samples_.empty() ? 1 : of_samples.size() / samples_.size();
}

void PixelBlend::pixels(const std::vector<SlopedLight>& of_samples, const SurfaceBuffer& buffer,
                        std::span<float* const> channels) const {
  const std::size_t lit = channels_of(of_samples);
  if (spread_) {
    spread(of_samples, buffer, channels);
    return;
  }
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

void PixelBlend::spread(const std::vector<SlopedLight>& of_samples, const SurfaceBuffer& buffer,
                        std::span<float* const> channels) const {
  const std::size_t count = channels_of(of_samples);
  std::vector<SlopedLight> of_points(4 * buffer.hits.size() * count);
  parallel_for(pieces_.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t n = first; n < last; ++n) {
      const Piece& piece = pieces_[n];
      std::size_t share = 0;
      for (std::size_t sixteen = 0; sixteen < piece.ends.size(); ++sixteen) {
        PointLights sums[3]{};
        for (; share < piece.ends[sixteen]; ++share) {
          add_share(piece.shares[share], of_samples.data(), count, sums);
        }
        const std::size_t begin = 4 * kTilesAPiece * n + kBlock * sixteen;
        for (std::size_t at = 0; at < kBlock && begin + at < 4 * buffer.hits.size(); ++at) {
          for (std::size_t c = 0; c < count; ++c) {
            const auto& [mean, x, y, z] = sums[c];
            of_points[(begin + at) * count + c] = {mean[at], {x[at], y[at], z[at]}};
          }
        }
      }
    }
  });
  parallel_for(buffer.hits.size(), kTilesAPiece, [&](std::size_t first, std::size_t last) {
    for (std::size_t tile = first; tile < last; ++tile) {
      spread_->light(buffer, tile, of_points.data(), channels.first(count));
      for (std::size_t c = count; c < channels.size(); ++c) {
        const std::size_t place = SurfaceBuffer::kTilePixels * tile;
        std::copy_n(channels[0] + place, SurfaceBuffer::kTilePixels, channels[c] + place);
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
                               piece.points.capacity() * sizeof(BlendWeight) +
                               (piece.ends.capacity() + piece.point_ends.capacity()) * 4);
  }
  return sum;
}

}  // namespace isolux
