#include "isolux/render/session.h"

#include <algorithm>

namespace isolux {
namespace {

bool same_surfaces(const Scene& a, const Scene& b) {
  return std::ranges::equal(a.surfaces, b.surfaces,
                            [](const auto& one, const auto& other) {
                              return one.volume == other.volume && one.iso == other.iso &&
                                     one.mesh == other.mesh;
                            }) &&
         a.visibility == b.visibility;
}

// What further points depend on beside the surfaces.
bool same_optics(const Scene& a, const Scene& b) {
  return a.mirror_depth == b.mirror_depth &&
         std::ranges::equal(a.surfaces, b.surfaces, [](const auto& one, const auto& other) {
           return one.material.kr == other.material.kr &&
                  one.material.opacity == other.material.opacity;
         });
}

bool same_shadows(const Scene& a, const Scene& b) {
  return a.shadows == b.shadows &&
         std::ranges::equal(a.lights, b.lights, [](const Light& one, const Light& other) {
           return one.kind == other.kind && one.place == other.place;
         });
}

bool same_request(const IndirectDescription& a, const IndirectDescription& b) {
  return a.indirect == b.indirect && a.bounces == b.bounces && a.spp == b.spp &&
         a.indirect_error == b.indirect_error && a.seed == b.seed && a.denoise == b.denoise &&
         a.indirect_memory == b.indirect_memory;
}

bool same_light(const Scene& a, const Scene& b) {
  return a.lights == b.lights && a.shadows == b.shadows && same_request(a, b) &&
         a.has_default_ambient == b.has_default_ambient && a.ambient == b.ambient &&
         a.background == b.background &&
         std::ranges::equal(a.surfaces, b.surfaces, [](const auto& one, const auto& other) {
           return one.material == other.material && one.change == other.change;
         });
}

// Indirect light depends on all that direct light does but the background.
bool same_indirect(const Scene& a, const Scene& b) {
  if (a.indirect == IndirectMethod::kOff && b.indirect == IndirectMethod::kOff) return true;
  Scene same = b;
  same.background = a.background;
  return same_light(a, same);
}

}  // namespace

void Session::trace(const Scene& scene, const ProgressListener& listener) {
  if (!prepared_ || !same_surfaces(*prepared_, scene)) {
    indirect_light_.forget();
    caster_ = RayCaster(scene, caster_ ? &*caster_ : nullptr);
    prepared_ = scene;
    traced_.reset();
    ++counters_.skip_structure;
  } else if (!same_optics(*prepared_, scene) ||
             needs_secondary_rays(*prepared_) != needs_secondary_rays(scene)) {
    if (!same_optics(*prepared_, scene)) {
      indirect_light_.forget();
      traced_.reset();
    }
    caster_ = RayCaster(scene, &*caster_);
    prepared_ = scene;
    shadowed_.reset();
  }
  if (traced_ && traced_->camera == scene.camera) return;
  const auto [width, height] = std::pair{scene.camera->width(), scene.camera->height()};
  if (!buffer_ || buffer_->width() != width || buffer_->height() != height) {
    buffer_.emplace(width, height);
  }
  traced_.reset();  // the listener may throw, and leave the buffer half written
  indirect_light_.forget_view();
  caster_->cast(*scene.camera, *buffer_, listener);
  traced_ = scene;
  shadowed_.reset();
  bounced_.reset();
  lit_.reset();
  drawn_.scene.reset();
  drawn_direct_.scene.reset();
  ++counters_.visibility;
}

const Shadows& Session::shadows(const Scene& scene) {
  trace(scene, {});
  if (shadowed_ && same_shadows(*shadowed_, scene)) return shadows_;
  cast_shadows(scene, caster_->surfaces(), *buffer_, shadows_);
  shadowed_ = scene;
  counters_.shadows += scene.shadows ? 1 : 0;
  return shadows_;
}

const Indirect& Session::indirect(const Scene& scene, const ProgressListener& listener,
                                  const std::function<bool()>& stop) {
  trace(scene, {});
  const bool is_found = bounced_ && same_indirect(*bounced_, scene);
  if (is_found && indirect_light_.is_complete()) return indirect_light_.found();
  if (is_found) {  // what was lit with less is lit again
    lit_.reset();
    drawn_.scene.reset();
  }
  bounced_.reset();  // the listener may throw
  indirect_light_.find(scene, caster_->surfaces(), *buffer_, listener, stop);
  counters_.indirect += scene.indirect == IndirectMethod::kOff ? 0 : 1;
  bounced_ = scene;
  return indirect_light_.found();
}

const Indirect& Session::indirect_as_found(const Scene& scene) {
  return bounced_ && same_indirect(*bounced_, scene) ? indirect_light_.found() : indirect(scene);
}

const SurfaceBuffer& Session::surfaces(const Scene& scene, const ProgressListener& listener) {
  trace(scene, listener);
  return *buffer_;
}

const Radiance& Session::radiance(const Scene& scene) {
  trace(scene, {});
  if (lit_ && same_light(*lit_, scene)) return *radiance_;
  radiance_ = light(scene, *buffer_, shadows(scene), indirect_as_found(scene));
  lit_ = scene;
  ++counters_.lighting;
  return *radiance_;
}

const Picture& Session::draw(const Scene& scene, Drawn& drawn) {
  const bool is_lit = drawn.scene && same_light(*drawn.scene, scene);
  if (is_lit && drawn.scene->display == scene.display) return drawn.picture.picture();
  if (is_lit) {
    drawn.picture.redisplay(scene, *buffer_);
  } else {
    const Indirect none;
    const bool has_indirect = scene.indirect != IndirectMethod::kOff;
    drawn.picture.relight(scene, *buffer_, shadows(scene),
                          has_indirect ? indirect_as_found(scene) : none);
  }
  counters_.lighting += is_lit ? 0 : 1;
  ++counters_.display;
  drawn.scene = scene;
  return drawn.picture.picture();
}

const Picture& Session::picture(const Scene& scene) {
  trace(scene, {});
  return draw(scene, drawn_);
}

const Picture& Session::direct_picture(const Scene& scene) {
  trace(scene, {});
  Scene direct = scene;
  direct.indirect = IndirectMethod::kOff;
  direct.ambient = {};
  direct.has_default_ambient = false;
  return draw(direct, drawn_direct_);
}

}  // namespace isolux
