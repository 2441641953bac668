#pragma once

#include <nlohmann/json_fwd.hpp>

#include "isolux/io/reader.h"

namespace isolux {

/// What `info --json` prints of a mesh.
nlohmann::json mesh_report(const ReadResult& input);

}  // namespace isolux
