#include "isolux/bench/own_renderer.h"

#include "isolux/mesh/mesh_box.h"
#include "isolux/render/path_tracer.h"
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

Scene described_scene(const SceneInput& input, const SurfaceDescription& surface, Vec3 low,
                      Vec3 high, int width, int height) {
  SceneDescription description;
  description.inputs = {"bench"};
  description.width = width;
  description.height = height;
  const View view = orbit_view(high - low, 0);
  description.camera = described({view.eye + low, view.target + low, view.fov_deg});
  description.surfaces = {surface};
  return resolve(description, {input});
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

void OwnRenderer::set_paths(int spp, int bounces) {
  scene_.shadows = true;
  scene_.indirect = IndirectMethod::kPath;
  scene_.spp = spp;
  scene_.bounces = bounces;
}

void OwnRenderer::prepare() { caster_ = RayCaster(scene_, caster_ ? &*caster_ : nullptr); }

void OwnRenderer::trace() {
  if (!buffer_) buffer_.emplace(scene_.camera->width(), scene_.camera->height());
  caster_->cast(*scene_.camera, *buffer_);
}

void OwnRenderer::relight() {
  cast_shadows(scene_, caster_->surfaces(), *buffer_, shadows_);
  picture_.relight(scene_, *buffer_, shadows_, followed_paths());
}

Indirect OwnRenderer::followed_paths() const {
  if (scene_.indirect == IndirectMethod::kOff) return {};
  PathTracer tracer(scene_, caster_->surfaces());
  tracer.run(*buffer_);
  return tracer.indirect(*buffer_);
}

void OwnRenderer::redisplay() { picture_.redisplay(scene_, *buffer_); }

void OwnRenderer::frame() {
  trace();
  relight();
}

std::size_t OwnRenderer::hit_pixels() const {
  std::size_t hits = 0;
  for (int y = 0; y < buffer_->height(); ++y) {
    for (int x = 0; x < buffer_->width(); ++x) hits += buffer_->is_hit(buffer_->at(x, y));
  }
  return hits;
}

Scene bench_scene(const std::shared_ptr<const Volume>& volume, double iso, int width, int height) {
  const auto corners = box_corners(*volume);
  return described_scene({volume}, {.iso = iso, .input = {}, .change = {}}, corners[0], corners[7],
                         width, height);
}

Scene bench_scene(const std::shared_ptr<const Mesh>& mesh, int width, int height) {
  const MeshBox box = box_of(*mesh);
  return described_scene({nullptr, mesh}, {.iso = {}, .input = 1, .change = {}}, box.low, box.high,
                         width, height);
}

Vec3 box_size(const SurfaceItem& surface) {
  if (surface.mesh) {
    const MeshBox box = box_of(*surface.mesh);
    return box.high - box.low;
  }
  const auto corners = box_corners(*surface.volume);
  return corners[7] - corners[0];
}

}  // namespace isolux
