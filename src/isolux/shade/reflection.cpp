#include "isolux/shade/reflection.h"

#include <algorithm>

#include "isolux/base/exact_math.h"

namespace isolux {

LightTerms light_terms(const Material& material, const Light& light, const SurfacePoint& point,
                       double visibility) {
  LightTerms t;
  t.visibility = visibility;
  const bool is_point = light.kind == Light::Kind::kPoint;
  t.offset = is_point ? light.place - point.position : light.place;
  t.distance = length(t.offset);
  if (t.distance == 0) return t;  // a lamp in the surface lights it from no direction
  t.to_light = t.offset / t.distance;
  t.cos_theta = dot(point.normal, t.to_light);
  t.reflected = 2 * t.cos_theta * point.normal - t.to_light;
  t.cos_phi = dot(t.reflected, point.to_eye);
  if (is_point && light.inverse_square_reference_mm) {
    const double ratio = *light.inverse_square_reference_mm / t.distance;
    t.falloff = ratio * ratio;
  }
  if (t.cos_theta <= 0) return t;
  t.phong = exact::pow(std::max(0.0, t.cos_phi), material.shininess);
  const double arriving = t.falloff * visibility;
  t.diffuse = t.cos_theta * arriving * (material.kd * light.intensity);
  t.specular = t.phong * arriving * (material.ks * light.intensity);
  return t;
}

Rgb irradiance(const Light& light, const SurfacePoint& point) {
  const Vec3 offset =
      light.kind == Light::Kind::kPoint ? light.place - point.position : light.place;
  const double distance = length(offset);
  if (distance == 0) return {};
  const double cos_theta = dot(point.normal, offset) / distance;
  if (cos_theta <= 0) return {};
  const double ratio = light.inverse_square_reference_mm.value_or(distance) / distance;
  return cos_theta * ratio * ratio * light.intensity;
}

Rgb ambient_term(const Material& material, Rgb ambient_light) {
  return material.ka * ambient_light;
}

}  // namespace isolux
