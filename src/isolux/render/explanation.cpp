#include "isolux/render/explanation.h"

#include <optional>

#include "isolux/render/indirect_light.h"
#include "isolux/render/ray_caster.h"
#include "isolux/render/relight.h"

namespace isolux {
namespace {

Rgb weight_of(const FurtherPoint& point) {
  return {point.weight[0], point.weight[1], point.weight[2]};
}

ExplainedLayer layer_of(const Scene& scene, std::int32_t surface, const MeshPoint& on_mesh,
                        const SurfacePoint& point, const std::vector<float>& shares,
                        const std::optional<Rgb>& irradiance) {
  ExplainedLayer layer;
  layer.surface = surface;
  layer.material = material_at(scene.surfaces[static_cast<std::size_t>(surface)], on_mesh);
  light_point(scene, surface, on_mesh, point, shares, irradiance ? &*irradiance : nullptr,
              layer.terms);
  return layer;
}

// Layers behind the nearest, mirrors and background.
void add_further(const Scene& scene, const FurtherPoint& point, const std::vector<float>& shares,
                 const std::optional<Rgb>& irradiance, Explanation& e) {
  const Rgb weight = weight_of(point);
  if (point.surface == FurtherPoint::kBackground) {
    Rgb& to = point.is_mirrored ? e.mirror : e.background;
    to = to + weight * scene.background;
    return;
  }
  ExplainedLayer layer =
      layer_of(scene, point.surface, point.point, point_of(point), shares, irradiance);
  if (point.is_mirrored) {
    e.mirror = e.mirror + layer.material.opacity * (weight * layer.terms.total);
    return;
  }
  layer.depth_mm = point.came_mm;
  e.layers.push_back(std::move(layer));
}

// What each bounce adds to E in a pixel, which with all of them is `all`: what one more adds to
// what fewer give.
std::vector<Rgb> by_bounce(const Scene& scene, const SceneSurfaces& surfaces,
                           const SurfaceBuffer& buffer, std::size_t place, const Rgb& all,
                           IndirectLight& light) {
  std::vector<Rgb> parts;
  Rgb before;
  Scene shorter = scene;
  for (int b = 1; b <= scene.bounces; ++b) {
    shorter.bounces = b;
    const Rgb now =
        b == scene.bounces ? all : light.find(shorter, surfaces, buffer).pixels.at(place);
    parts.push_back(now + -1.0 * before);
    before = now;
  }
  return parts;
}

}  // namespace

Explanation explain(const Scene& scene, int x, int y) {
  const RayCaster caster(scene);
  const PixelView view = caster.cast_around(*scene.camera, x, y);
  // What is denoised depends on pixels around, wherever they lie.
  const SurfaceBuffer buffer = scene.denoise ? caster.cast(*scene.camera) : view.buffer;
  Shadows shadows;
  cast_shadows(scene, caster.surfaces(), buffer, shadows);
  const std::size_t place = buffer.at(x - buffer.first_x, y - buffer.first_y);
  Indirect indirect;

  Explanation e;
  if (scene.indirect != IndirectMethod::kOff) {
    IndirectLight light;
    indirect = light.find(scene, caster.surfaces(), buffer);
    if (buffer.is_hit(place)) {
      const Rgb all = indirect.pixels.at(place);
      e.by_bounce = by_bounce(scene, caster.surfaces(), buffer, place, all, light);
      e.first_bounce = first_bounce(scene, caster.surfaces(), buffer, place);
    }
  }
  e.x = x;
  e.y = y;
  e.eye_ray = scene.camera->ray(x, y);
  e.turned = view.turned;
  e.radiance = light(scene, buffer, shadows, indirect).total.at(place);
  const SurfaceSample sample = buffer.sample(place);
  if (sample.is_hit()) {
    e.layers.push_back(layer_of(scene, sample.surface, sample.point, point_of(e.eye_ray, sample),
                                shadows.of_pixel(place), indirect.of_pixel(place)));
    e.layers[0].depth_mm = sample.depth_mm;
    const std::size_t tile = place / SurfaceBuffer::kTilePixels;
    for (std::size_t n = 0; !buffer.further.empty() && n < buffer.further[tile].size(); ++n) {
      const FurtherPoint& point = buffer.further[tile][n];
      if (point.pixel == place % SurfaceBuffer::kTilePixels)
        add_further(scene, point, shadows.of_further(tile, n), indirect.of_further(tile, n), e);
    }
  } else {
    e.background = scene.background;
  }
  e.total = e.mirror + e.background;
  double open = 1;
  for (ExplainedLayer& layer : e.layers) {
    layer.weight = open * layer.material.opacity;
    open *= 1 - layer.material.opacity;
    e.total = e.total + layer.weight * layer.terms.total;
  }
  const DisplayTable table(scene.display);
  for (int c = 0; c < 3; ++c) {
    e.shown[static_cast<std::size_t>(c)] = table.byte(static_cast<float>(e.radiance[c]));
  }
  return e;
}

}  // namespace isolux
