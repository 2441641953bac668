#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "isolux/render/surface_buffer.h"
#include "isolux/scene/document.h"
#include "isolux/scene/scene.h"

// Scenes for tests.

namespace isolux {

constexpr int kTestSize = 48;

/// A scene as --scene would make it, of 48 x 48 pixels if `settings` does not say otherwise.
inline Scene scene_of(const std::vector<SceneInput>& inputs, const nlohmann::json& settings) {
  nlohmann::json document = empty_document();
  document["size"] = {kTestSize, kTestSize};
  document.update(settings);
  SceneDescription description = describe(document, "scene");
  description.inputs.resize(inputs.size());
  for (std::size_t n = 0; n < inputs.size(); ++n) description.inputs[n] = std::to_string(n);
  return resolve(description, inputs);
}

inline SceneInput volume(Volume v) { return {std::make_shared<const Volume>(std::move(v))}; }
inline SceneInput mesh(Mesh m) { return {nullptr, std::make_shared<const Mesh>(std::move(m))}; }

/// A square of half width `half` at height z whose outside is towards +z or, `down`, -z. Red grows
/// with x, green with y, from 0 to 1 over the square.
inline Mesh square(double z, double half, bool down) {
  Mesh m;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    m.positions.push_back(
        {static_cast<float>(x * half), static_cast<float>(y * half), static_cast<float>(z)});
    m.colors.push_back({static_cast<float>(x + 1) / 2, static_cast<float>(y + 1) / 2, 0.25f});
  }
  m.triangles = {{0, 1, 2}, {0, 2, 3}};
  if (down) m.triangles = {{0, 2, 1}, {0, 3, 2}};
  m.materials.push_back({"", Material{{1, 1, 1}, {0.5, 0.5, 0.5}, {}, 1}, nullptr});
  m.parts.push_back({0, 2, 0});
  return m;
}

/// Calls body(place) for every pixel that shows a surface; how many there are.
template <typename Body>
int each_hit(const SurfaceBuffer& buffer, const Body& body) {
  int hits = 0;
  for (std::size_t place = 0; place < buffer.pixels(); ++place) {
    if (!buffer.is_hit(place)) continue;
    ++hits;
    body(place);
  }
  return hits;
}

}  // namespace isolux
