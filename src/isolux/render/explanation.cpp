#include "isolux/render/explanation.h"

#include "isolux/render/ray_caster.h"

namespace isolux {

Explanation explain(const Scene& scene, int x, int y) {
  Explanation e;
  e.x = x;
  e.y = y;
  e.eye_ray = scene.camera->ray(x, y);
  e.radiance = scene.background;
  const PixelHit hit = RayCaster(scene).cast_pixel(*scene.camera, x, y);
  e.sample = hit.sample;
  e.turned = hit.turned;
  if (hit.sample.is_hit()) {
    light_sample(scene, e.eye_ray, e.sample, e.terms);
    e.radiance = e.terms.total;
  }
  RgbLayer as_floats(1);
  as_floats.set(0, e.radiance);
  e.radiance = as_floats.at(0);
  e.shown = displayed(scene.display, e.radiance);
  return e;
}

}  // namespace isolux
