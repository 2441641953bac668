#include "isolux/render/lighting.h"

#include "isolux/base/parallel.h"

namespace isolux {

void RgbLayer::set(std::size_t pixel, Rgb value) {
  r[pixel] = static_cast<float>(value.r);
  g[pixel] = static_cast<float>(value.g);
  b[pixel] = static_cast<float>(value.b);
}

void light_sample(const Scene& scene, const Ray& eye_ray, const SurfaceSample& sample,
                  PixelTerms& terms) {
  const Material& material = scene.surfaces[static_cast<std::size_t>(sample.surface)].material;
  terms.point = {eye_ray.at(sample.depth_mm), sample.normal(), -eye_ray.direction};
  terms.ambient = ambient_term(material, scene.ambient);
  terms.lights.clear();
  terms.diffuse = terms.specular = Rgb{};
  for (const Light& one : scene.lights) {
    const LightTerms& added = terms.lights.emplace_back(light_terms(material, one, terms.point));
    terms.diffuse = terms.diffuse + added.diffuse;
    terms.specular = terms.specular + added.specular;
  }
  terms.total = terms.ambient + terms.diffuse + terms.specular;
}

Radiance light(const Scene& scene, const SurfaceBuffer& buffer) {
  Radiance radiance(buffer.pixels());
  parallel_for(static_cast<std::size_t>(buffer.height()), 16,
               [&](std::size_t begin, std::size_t end) {
                 PixelTerms terms;
                 for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
                   for (int x = 0; x < buffer.width(); ++x) {
                     const std::size_t pixel = buffer.at(x, y);
                     const SurfaceSample sample = buffer.sample(pixel);
                     if (!sample.is_hit()) {
                       radiance.total.set(pixel, scene.background);
                       continue;
                     }
                     light_sample(scene, scene.camera->ray(x, y), sample, terms);
                     radiance.ambient.set(pixel, terms.ambient);
                     radiance.diffuse.set(pixel, terms.diffuse);
                     radiance.specular.set(pixel, terms.specular);
                     radiance.total.set(pixel, terms.total);
                   }
                 }
               });
  return radiance;
}

}  // namespace isolux
