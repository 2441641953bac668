#include "isolux/render/mesh_view.h"

namespace isolux {
namespace {

PixelRays pixel_rays(const Camera& camera) {
  const RayFan fan = camera.fan();
  return {camera.width(),
          camera.height(),
          {fan.origin.first, fan.origin.along_x, fan.origin.along_y},
          {fan.direction.first, fan.direction.along_x, fan.direction.along_y}};
}

}  // namespace

MeshView::MeshView(std::shared_ptr<const MeshSurface> surface, const Camera& camera)
    : surface_(std::move(surface)), fan_(camera.fan()) {}

MeshView::MeshView(const Mesh& mesh, const Camera& camera)
    : fan_(camera.fan()), raster_(rasterise(mesh, pixel_rays(camera))) {}

std::optional<MeshHit> MeshView::hit(int x, int y, double t_max) const {
  std::optional<MeshHit> found;
  if (surface_) {
    found = surface_->first_hit(fan_.ray(x, y), t_max);
  } else if (const std::size_t at = raster_.at(x, y);
             raster_.triangle[at] != RasterBuffer::kNothing) {
    found = {raster_.t[at], raster_.triangle[at], raster_.u[at], raster_.v[at]};
  }
  return found && found->t < t_max ? found : std::nullopt;
}

}  // namespace isolux
