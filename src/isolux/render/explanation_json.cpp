#include "isolux/render/explanation_json.h"

#include <nlohmann/json.hpp>

#include "isolux/render/surface_buffer.h"

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
          {"visibility", t.visibility},
          {"diffuse", numbers(t.diffuse)},
          {"specular", numbers(t.specular)}};
}

// The place and vectors of a layer, and its terms times `weight`.
json layer_json(const ExplainedLayer& layer, double weight) {
  json object = {{"surface", layer.surface},
                 {"to_eye", numbers(layer.terms.point.to_eye)},
                 {"position", numbers(layer.terms.point.position)},
                 {"normal", numbers(layer.terms.point.normal)},
                 {"depth", layer.depth_mm},
                 {"ambient", numbers(weight * layer.terms.ambient)},
                 {"indirect", numbers(weight * layer.terms.indirect)},
                 {"lights", json::array()}};
  for (LightTerms t : layer.terms.lights) {
    t.diffuse = weight * t.diffuse;
    t.specular = weight * t.specular;
    object["lights"].push_back(light_json(t));
  }
  return object;
}

// What all layers add to each term: the nearest one's vectors, with the sums of the terms.
json summed_json(const Explanation& e) {
  ExplainedLayer nearest = e.layers[0];
  PointTerms& sum = nearest.terms;
  const double own = nearest.weight;
  sum.ambient = own * sum.ambient;
  sum.indirect = own * sum.indirect;
  for (LightTerms& t : sum.lights) {
    t.diffuse = own * t.diffuse;
    t.specular = own * t.specular;
  }
  for (std::size_t k = 1; k < e.layers.size(); ++k) {
    const ExplainedLayer& layer = e.layers[k];
    sum.ambient = sum.ambient + layer.weight * layer.terms.ambient;
    sum.indirect = sum.indirect + layer.weight * layer.terms.indirect;
    for (std::size_t l = 0; l < sum.lights.size(); ++l) {
      LightTerms& t = sum.lights[l];
      t.diffuse = t.diffuse + layer.weight * layer.terms.lights[l].diffuse;
      t.specular = t.specular + layer.weight * layer.terms.lights[l].specular;
    }
  }
  return layer_json(nearest, 1);
}

json first_bounce_json(const FirstBounce& first) {
  json senders = json::array();
  for (const Sender& sender : first.senders) {
    senders.push_back({{"surface", sender.surface},
                       {"position", numbers(sender.position)},
                       {"share", sender.share}});
  }
  return {{"light", first.light}, {"sky", first.sky_share}, {"senders", std::move(senders)}};
}

}  // namespace

json explain_json(const Explanation& e) {
  json object = {{"pixel", {e.x, e.y}},
                 {"hit", e.is_hit()},
                 {"surface", SurfaceSample::kNothing},
                 {"to_eye", numbers(-e.eye_ray.direction)},
                 {"position", numbers(Vec3{})},
                 {"normal", numbers(Vec3{})},
                 {"ambient", numbers(Rgb{})},
                 {"lights", json::array()},
                 {"layers", json::array()},
                 {"indirect", numbers(Rgb{})},
                 {"mirror", numbers(e.mirror)},
                 {"background", numbers(e.background)},
                 {"total", numbers(e.total)},
                 {"display", e.shown}};
  if (e.is_hit()) object.update(summed_json(e));
  for (const Rgb& part : e.by_bounce) object["bounces"].push_back(numbers(part));
  if (!e.by_bounce.empty()) object["first_bounce"] = first_bounce_json(e.first_bounce);
  for (const ExplainedLayer& layer : e.layers) {
    json own = layer_json(layer, 1);
    own["opacity"] = layer.material.opacity;
    own["weight"] = layer.weight;
    own["total"] = numbers(layer.terms.total);
    object["layers"].push_back(std::move(own));
  }
  return object;
}

}  // namespace isolux
