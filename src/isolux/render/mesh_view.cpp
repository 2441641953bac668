#include "isolux/render/mesh_view.h"

#include <algorithm>

#include "isolux/intersect/triangle_setup.h"
#include "isolux/render/ray_packet.h"

namespace isolux {
namespace {

PixelRays pixel_rays(const Camera& camera) {
  const RayFan fan = camera.fan();
  return {camera.width(),
          camera.height(),
          {fan.origin.first, fan.origin.along_x, fan.origin.along_y},
          {fan.direction.first, fan.direction.along_x, fan.direction.along_y}};
}

// The pixels that a box covers, and one more to each side; all where it passes the eye.
raster::PixelBox pixels_of(const MeshBox& box, const PixelRays& rays) {
  const raster::Projection projection(rays);
  raster::PixelBox pixels{rays.width, rays.height, -1, -1};
  for (int n = 0; n < 8; ++n) {
    const raster::Projected corner =
        projection(as_float({n & 1 ? box.high.x : box.low.x, n & 2 ? box.high.y : box.low.y,
                             n & 4 ? box.high.z : box.low.z}));
    if (!(corner.z > 0)) return {0, 0, rays.width - 1, rays.height - 1};
    const auto whole = [](double at, int count) {
      return static_cast<int>(std::clamp(at, -2.0, count + 2.0));
    };
    const auto [x, y] = projection.pixel(corner);
    pixels.x0 = std::min(pixels.x0, whole(x, rays.width) - 1);
    pixels.y0 = std::min(pixels.y0, whole(y, rays.height) - 1);
    pixels.x1 = std::max(pixels.x1, whole(x, rays.width) + 1);
    pixels.y1 = std::max(pixels.y1, whole(y, rays.height) + 1);
  }
  return pixels;
}

}  // namespace

MeshView::MeshView(std::shared_ptr<const MeshSurface> surface, const Camera& camera)
    : surface_(std::move(surface)), box_(pixels_of(surface_->box(), pixel_rays(camera))) {}

MeshView::MeshView(const Mesh& mesh, const Camera& camera)
    : raster_(rasterise(mesh, pixel_rays(camera))) {}

bool MeshView::is_empty_at(int x0, int y0) const {
  if (!surface_) return raster_.is_empty_at(x0, y0);
  return x0 > box_.x1 || x0 + 7 < box_.x0 || y0 > box_.y1 || y0 + 3 < box_.y0;
}

std::uint32_t MeshView::inside_box(int x0, int y0) const {
  std::uint32_t lanes = 0;
  for (int n = 0; n < RayPacket::kCount; ++n) {
    const int x = x0 + RayPacket::x_of(n), y = y0 + RayPacket::y_of(n);
    const bool is_inside = x >= box_.x0 && x <= box_.x1 && y >= box_.y0 && y <= box_.y1;
    lanes |= std::uint32_t{is_inside} << n;
  }
  return lanes;
}

std::uint32_t MeshView::triangles(const RayLanes& rays, std::uint32_t lanes, int x0, int y0,
                                  std::uint32_t* triangle) const {
  if (surface_) {
    MeshHitLanes hits;
    surface_->first_hits(rays, lanes & inside_box(x0, y0), hits);
    std::ranges::copy(hits.triangle, triangle);
    return hits.hit;
  }
  std::uint32_t met = 0;
  for (int n = 0; n < RayPacket::kCount; n += 4) {
    const int x = x0 + RayPacket::x_of(n), y = y0 + RayPacket::y_of(n);
    std::copy_n(raster_.triangles(x, y), 4, triangle + n);
  }
  for (int n = 0; n < RayPacket::kCount; ++n) {
    met |= std::uint32_t{triangle[n] != RasterBuffer::kNothing} << n;
  }
  return met & lanes;
}

}  // namespace isolux
