#include "isolux/bench/own_renderer.h"

#include <algorithm>
#include <atomic>

#include "isolux/base/parallel.h"
#include "isolux/render/pictures.h"
#include "isolux/scene/description.h"

namespace isolux {
namespace {

Light headlight(const Camera& camera) {
  Light light;
  light.place = camera.world_from_camera().vector({0, 0, 1});
  return light;
}

CameraDescription described(const View& view) {
  return {.eye = view.eye, .target = view.target, .fov_deg = view.fov_deg};
}

}  // namespace

OwnRenderer::OwnRenderer(Scene scene) : scene_(std::move(scene)) {}

void OwnRenderer::look(const View& view) {
  scene_.camera.emplace(described(view), scene_.camera->width(), scene_.camera->height(),
                        BoundingSphere{});
  if (scene_.has_default_light) scene_.lights[0] = headlight(*scene_.camera);
}

void OwnRenderer::set_lamp(std::optional<Vec3> at) {
  scene_.has_default_light = !at;
  Light& lamp = scene_.lights[0];
  lamp = headlight(*scene_.camera);
  if (!at) return;
  lamp.kind = Light::Kind::kPoint;
  lamp.place = *at;
}

void OwnRenderer::prepare() { caster_ = RayCaster(scene_, caster_ ? &*caster_ : nullptr); }

void OwnRenderer::trace() { buffer_ = caster_->cast(*scene_.camera); }

void OwnRenderer::relight() { radiance_ = light(scene_, *buffer_); }

void OwnRenderer::show() { picture_ = displayed_picture(scene_, *radiance_); }

void OwnRenderer::frame() {
  trace();
  relight();
  show();
}

std::size_t OwnRenderer::hit_pixels() const {
  return buffer_->surface.size() -
         static_cast<std::size_t>(std::ranges::count(buffer_->surface, SurfaceSample::kNothing));
}

std::size_t OwnRenderer::count_hits(const std::vector<Ray>& rays) const {
  std::atomic<std::size_t> hits{0};
  parallel_for(rays.size(), 4096, [&](std::size_t begin, std::size_t end) {
    std::size_t met = 0;
    for (std::size_t n = begin; n < end; ++n) met += caster_->first_hit(rays[n]).has_value();
    hits += met;
  });
  return hits;
}

Scene bench_scene(const std::shared_ptr<const Volume>& volume, double iso, int width, int height) {
  SceneDescription description;
  description.inputs = {"bench"};
  description.width = width;
  description.height = height;
  const auto corners = box_corners(*volume);
  const View view = orbit_view(corners[7] - corners[0], 0);
  description.camera = described({view.eye + corners[0], view.target + corners[0], view.fov_deg});
  description.surfaces = {{.iso = iso, .input = {}, .material = {}}};
  return resolve(description, {volume});
}

}  // namespace isolux
