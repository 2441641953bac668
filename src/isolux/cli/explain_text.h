#pragma once

#include <string>

#include "isolux/render/explanation.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// An explanation as text to read beside the lecture. Each step is a line `name = formula = numbers
/// = result`, so that the numbers can be worked out again. Nine significant digits.
std::string explain_text(const Scene& scene, const Explanation& explanation,
                         const std::string& surface_name);

}  // namespace isolux
