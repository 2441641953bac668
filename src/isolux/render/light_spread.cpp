#include "isolux/render/light_spread.h"

#include <algorithm>
#include <array>

#include "isolux/base/parallel.h"

namespace isolux {
namespace {

constexpr std::size_t kTilesAPiece = 64;

}  // namespace

std::optional<std::size_t> LightSpread::place(const SurfaceBuffer& buffer, std::size_t tile,
                                              std::size_t block) {
  constexpr std::size_t kBlock = SurfaceBuffer::kBlockPixels;
  constexpr std::array<std::size_t, kBlock> kFromTheMiddle = {5, 10, 6, 9, 1, 14, 4, 11,
                                                              2, 13, 7, 8, 0, 15, 3, 12};
  const std::uint64_t hits = buffer.hits[tile] >> (kBlock * block);
  for (const std::size_t n : kFromTheMiddle) {
    if (hits >> n & 1) return SurfaceBuffer::kTilePixels * tile + kBlock * block + n;
  }
  return std::nullopt;
}

LightSpread::LightSpread(const Camera& camera, const SurfaceBuffer& buffer,
                         const std::vector<double>& thickness_mm)
    : fan_(camera.fan()),
      is_orthographic_(camera.is_orthographic()),
      points_(4 * buffer.hits.size(), Point{kNone, 0, 0, {}, {}, 0}) {
  fan_.origin.first = fan_.origin.first - camera.eye();
  parallel_for(buffer.hits.size(), kTilesAPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = 4 * begin; n < 4 * end; ++n) {
      const auto at = place(buffer, n / 4, n % 4);
      if (!at) continue;
      const auto [x, y] = buffer.pixel(*at);
      const SurfaceSample sample = buffer.sample(*at);
      const Vec3 position = camera.ray(x, y).at(sample.depth_mm) - camera.eye();
      const double thickness = thickness_mm[static_cast<std::size_t>(sample.surface)];
      points_[n] = {sample.surface,
                    static_cast<float>(x),
                    static_cast<float>(y),
                    as_float(position),
                    as_float(sample.normal()),
                    static_cast<float>(1 / (thickness * thickness))};
    }
  });
}

void LightSpread::light(const SurfaceBuffer& buffer, std::size_t tile, const SlopedLight* of_points,
                        std::span<float* const> to) const {
  const int across = 2 * buffer.tiles_x(), down = 2 * buffer.tiles_y();
  const auto tiles_x = static_cast<std::size_t>(buffer.tiles_x());
  const int left = 2 * static_cast<int>(tile % tiles_x), top = 2 * static_cast<int>(tile / tiles_x);
  for (int own = 0; own < 4; ++own) {
    SpreadBlock block;
    block.place = SurfaceBuffer::kTilePixels * tile +
                  static_cast<std::size_t>(SurfaceBuffer::kBlockPixels * own);
    const auto [x, y] = buffer.pixel(block.place);
    block.x = static_cast<float>(x);
    block.y = static_cast<float>(y);
    const auto add = [&](int dx, int dy) {
      const int bx = left + (own & 1) + dx, by = top + own / 2 + dy;
      if (bx < 0 || by < 0 || bx >= across || by >= down) return;
      const std::size_t n =
          4 * (static_cast<std::size_t>(by / 2) * tiles_x + static_cast<std::size_t>(bx / 2)) +
          static_cast<std::size_t>(2 * (by & 1) + (bx & 1));
      if (points_[n].surface == kNone) return;
      block.points[block.count] = &points_[n];
      block.lights[block.count++] = of_points + to.size() * n;
    };
    add(0, 0);
    if (block.count == 0) {
      for (float* channel : to)
        std::fill_n(channel + block.place, SurfaceBuffer::kBlockPixels, 0.0f);
      continue;
    }
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx != 0 || dy != 0) add(dx, dy);
      }
    }
    spread_light(block, buffer, fan_, is_orthographic_, to);
  }
}

}  // namespace isolux
