#pragma once

#include <string>
#include <vector>

#include "isolux/render/explanation.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// An explanation as text to read beside the lecture. Each step is a line `name = formula = numbers
/// = result`, so that the numbers can be worked out again. Nine significant digits.
/// @param surface_names  what each of Scene::surfaces is called.
std::string explain_text(const Scene& scene, const Explanation& explanation,
                         const std::vector<std::string>& surface_names);

}  // namespace isolux
