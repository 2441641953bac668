#include "isolux/render/lighting.h"

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

}  // namespace isolux
