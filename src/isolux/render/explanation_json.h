#pragma once

#include <nlohmann/json_fwd.hpp>

#include "isolux/render/explanation.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// An explanation as the contract's JSON object.
nlohmann::json explain_json(const Scene& scene, const Explanation& explanation);

}  // namespace isolux
