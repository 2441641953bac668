#include "isolux/render/explanation.h"

#include "isolux/render/ray_caster.h"
#include "isolux/render/relight.h"

namespace isolux {

Explanation explain(const Scene& scene, int x, int y) {
  Explanation e;
  e.x = x;
  e.y = y;
  e.eye_ray = scene.camera->ray(x, y);
  const PixelHit hit = RayCaster(scene).cast_pixel(*scene.camera, x, y);
  e.sample = hit.sample;
  e.turned = hit.turned;
  if (hit.sample.is_hit()) {
    light_sample(scene, e.eye_ray, e.sample, e.terms);
    e.radiance = light_pixel(scene, e.sample, x, y);
  } else {
    RgbLayer as_floats(1);
    as_floats.set(0, scene.background);
    e.radiance = as_floats.at(0);
  }
  const DisplayTable table(scene.display);
  for (int c = 0; c < 3; ++c) {
    e.shown[static_cast<std::size_t>(c)] = table.byte(static_cast<float>(e.radiance[c]));
  }
  return e;
}

}  // namespace isolux
