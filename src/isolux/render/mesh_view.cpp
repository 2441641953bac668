#include "isolux/render/mesh_view.h"

#include <algorithm>
#include <bit>

#include "isolux/intersect/triangle_setup.h"

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

std::uint32_t MeshView::possible(const int* x, const int* y) const {
  if (!surface_) return ~0u;
  std::uint32_t lanes = 0;
  for (int n = 0; n < RayLanes::kCount; ++n) {
    const bool is_inside = x[n] >= box_.x0 && x[n] <= box_.x1 && y[n] >= box_.y0 && y[n] <= box_.y1;
    lanes |= std::uint32_t{is_inside} << n;
  }
  return lanes;
}

std::uint32_t MeshView::triangles(const RayLanes& rays, std::uint32_t lanes, const int* x,
                                  const int* y, std::uint32_t* triangle) const {
  if (surface_) {
    MeshHitLanes hits;
    surface_->first_hits(rays, lanes, hits);
    for (int n = 0; n < RayLanes::kCount; ++n) triangle[n] = hits.triangle[n];
    return hits.hit;
  }
  std::uint32_t met = 0;
  for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const int n = std::countr_zero(rest);
    triangle[n] = raster_.triangle(x[n], y[n]);
    if (triangle[n] != RasterBuffer::kNothing) met |= 1u << n;
  }
  return met;
}

}  // namespace isolux
