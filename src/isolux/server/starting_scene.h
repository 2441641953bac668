#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "isolux/scene/scene.h"

namespace isolux {

/// The document with all its surfaces named, in the order in which they are drawn: also those that
/// `resolve` adds by itself.
nlohmann::json with_all_surfaces(const nlohmann::json& document,
                                 const std::vector<SceneInput>& inputs);

/// A scene to begin with: every default written out, all surfaces named, and, where no light was
/// asked for, a lamp that can be seen and dragged: before the face, above it and to its right.
nlohmann::json starting_scene(const nlohmann::json& document,
                              const std::vector<SceneInput>& inputs);

}  // namespace isolux
