#include "isolux/server/starting_scene.h"

#include <algorithm>
#include <cmath>

#include "isolux/scene/document.h"
#include "isolux/volume/statistics.h"

namespace isolux {

using nlohmann::json;

json with_all_surfaces(const json& document, const std::vector<SceneInput>& inputs) {
  json scene = document;
  json& surfaces = scene["surface"];
  if (surfaces.is_null()) surfaces = json::array();
  const auto is_iso = [](const json& surface) { return surface.contains("iso"); };
  const bool names_volumes = std::ranges::any_of(surfaces, is_iso);
  for (std::size_t n = 0; n < inputs.size(); ++n) {
    if (!inputs[n].volume || names_volumes) continue;
    const auto suggested = suggest_iso(*inputs[n].volume, value_statistics(*inputs[n].volume));
    if (suggested.empty()) continue;
    surfaces.push_back({{"iso", suggested[0].value}});
    if (inputs.size() > 1) surfaces.back()["input"] = n + 1;
  }
  for (std::size_t n = 0; n < inputs.size(); ++n) {
    const auto is_it = [&](const json& surface) {
      return !is_iso(surface) && surface.value("input", std::size_t{1}) == n + 1;
    };
    if (inputs[n].mesh && std::ranges::none_of(surfaces, is_it)) {
      surfaces.push_back({{"input", n + 1}});
    }
  }
  return scene;
}

json starting_scene(const json& document, const std::vector<SceneInput>& inputs) {
  json scene = with_all_surfaces(document, inputs);
  if (!scene.contains("light")) {
    const BoundingSphere sphere = bounding_sphere(inputs);
    const Vec3 at = sphere.center + sphere.radius_mm * Vec3{-0.3, -0.7, 0.24};
    // In short numbers: whole millimetres, or finer where all is smaller.
    const double per_mm = std::max(1.0, std::pow(10, 2 - std::floor(std::log10(sphere.radius_mm))));
    const auto rounded = [&](double v) { return std::round(v * per_mm) / per_mm; };
    scene["light"] = {{{"kind", "point"}, {"at", {rounded(at.x), rounded(at.y), rounded(at.z)}}}};
  }
  return with_defaults(scene);
}

}  // namespace isolux
