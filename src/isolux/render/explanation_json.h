#pragma once

#include <nlohmann/json_fwd.hpp>

#include "isolux/render/explanation.h"

namespace isolux {

/// An explanation as the contract's JSON object.
nlohmann::json explain_json(const Explanation& explanation);

}  // namespace isolux
