#include "isolux/render/seen.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace isolux {
namespace {

struct Nearest {
  double distance_mm = std::numeric_limits<double>::infinity();
  Vec3 point;
  int x = 0;
  int y = 0;
};

void look_at(const Camera& camera, const SurfaceBuffer& buffer, Vec3 place, int x, int y,
             Nearest& best) {
  if (x >= buffer.width() || y >= buffer.height()) return;  // tiles reach over the edges
  const std::size_t at = buffer.at(x, y);
  if (!buffer.is_hit(at)) return;
  const Vec3 point = camera.ray(x, y).at(buffer.depth_mm[at]);
  const double distance_mm = length(point - place);
  if (distance_mm < best.distance_mm) best = {distance_mm, point, x, y};
}

}  // namespace

std::optional<PicturePart> seen_part(const SurfaceBuffer& buffer) {
  int left = buffer.width(), top = buffer.height(), right = -1, bottom = -1;
  for (int y = 0; y < buffer.height(); ++y) {
    for (int x = 0; x < buffer.width(); ++x) {
      const bool is_inside = x >= left && x <= right && y >= top && y <= bottom;
      if (is_inside || !buffer.is_hit(buffer.at(x, y))) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  if (right < 0) return std::nullopt;
  const double width = buffer.width(), height = buffer.height();
  return PicturePart{left / width, top / height, (right + 1) / width, (bottom + 1) / height};
}

std::optional<Vec3> nearest_seen(const Camera& camera, const SurfaceBuffer& buffer, Vec3 place) {
  constexpr int kTile = SurfaceBuffer::kTile;
  Nearest best;
  for (int y = 0; y < buffer.height(); y += kTile) {
    for (int x = 0; x < buffer.width(); x += kTile) {
      const std::size_t tile = buffer.at(x, y) / SurfaceBuffer::kTilePixels;
      if (buffer.hits[tile] == 0) continue;
      const int first =
          std::countr_zero(buffer.hits[tile]);  // of the bits that SurfaceBuffer::at tells
      look_at(camera, buffer, place, x + (first & 16) / 4 + (first & 3),
              y + (first & 32) / 8 + (first & 12) / 4, best);
    }
  }
  const int x0 = std::max(0, best.x - kTile), x1 = std::min(buffer.width(), best.x + kTile + 1);
  const int y0 = std::max(0, best.y - kTile), y1 = std::min(buffer.height(), best.y + kTile + 1);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) look_at(camera, buffer, place, x, y, best);
  }
  if (best.distance_mm == std::numeric_limits<double>::infinity()) return std::nullopt;
  return best.point;
}

}  // namespace isolux
