#include "isolux/render/explanation_json.h"

#include <nlohmann/json.hpp>

namespace isolux {
namespace {

using nlohmann::json;

json numbers(Vec3 v) { return {v.x, v.y, v.z}; }
json numbers(Rgb c) { return {c.r, c.g, c.b}; }

json light_json(const LightTerms& t) {
  return {{"to_light", numbers(t.to_light)},
          {"reflected", numbers(t.reflected)},
          {"distance", t.distance},
          {"cos_theta", t.cos_theta},
          {"cos_phi", t.cos_phi},
          {"falloff", t.falloff},
          {"visibility", 1.0},
          {"diffuse", numbers(t.diffuse)},
          {"specular", numbers(t.specular)}};
}

}  // namespace

json explain_json(const Scene& scene, const Explanation& e) {
  json object = {{"pixel", {e.x, e.y}},
                 {"hit", e.sample.is_hit()},
                 {"surface", e.sample.surface},
                 {"to_eye", numbers(-e.eye_ray.direction)},
                 {"position", numbers(Vec3{})},
                 {"normal", numbers(Vec3{})},
                 {"ambient", numbers(Rgb{})},
                 {"lights", json::array()},
                 {"indirect", numbers(Rgb{})},
                 {"mirror", numbers(Rgb{})},
                 {"total", numbers(scene.background)},
                 {"display", e.shown}};
  if (!e.sample.is_hit()) return object;
  object["position"] = numbers(e.terms.point.position);
  object["normal"] = numbers(e.terms.point.normal);
  object["depth"] = e.sample.depth_mm;
  object["ambient"] = numbers(e.terms.ambient);
  for (const LightTerms& t : e.terms.lights) object["lights"].push_back(light_json(t));
  object["total"] = numbers(e.terms.total);
  return object;
}

}  // namespace isolux
