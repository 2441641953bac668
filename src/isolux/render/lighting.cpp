#include "isolux/render/lighting.h"

namespace isolux {

void RgbLayer::set(std::size_t pixel, Rgb value) {
  r[pixel] = static_cast<float>(value.r);
  g[pixel] = static_cast<float>(value.g);
  b[pixel] = static_cast<float>(value.b);
}

void light_point(const Scene& scene, std::int32_t surface, const MeshPoint& on_mesh,
                 const SurfacePoint& point, std::span<const float> shares, const Rgb* irradiance,
                 PointTerms& terms) {
  const Material material = material_at(scene.surfaces[static_cast<std::size_t>(surface)], on_mesh);
  terms.point = point;
  terms.ambient = irradiance ? Rgb{} : ambient_term(material, scene.ambient);
  terms.irradiance = irradiance ? *irradiance : Rgb{};
  terms.indirect = material.kd * terms.irradiance;
  terms.lights.clear();
  terms.diffuse = terms.specular = Rgb{};
  for (std::size_t n = 0; n < scene.lights.size(); ++n) {
    const LightTerms& added = terms.lights.emplace_back(
        light_terms(material, scene.lights[n], point, shares.empty() ? 1 : shares[n]));
    terms.diffuse = terms.diffuse + added.diffuse;
    terms.specular = terms.specular + added.specular;
  }
  terms.total = terms.ambient + terms.indirect + terms.diffuse + terms.specular;
}

SurfacePoint point_of(const Ray& eye_ray, const SurfaceSample& sample) {
  return {eye_ray.at(sample.depth_mm), sample.normal(), -eye_ray.direction};
}

SurfacePoint point_of(const FurtherPoint& further) {
  const auto& [nx, ny, nz] = further.normal;
  const auto& [ex, ey, ez] = further.to_eye;
  return {further.position, {nx, ny, nz}, {ex, ey, ez}};
}

}  // namespace isolux
