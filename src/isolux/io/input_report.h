#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "isolux/io/reader.h"
#include "isolux/volume/statistics.h"

namespace isolux {

/// What drawing surfaces of a volume takes in bytes, beside the picture: what its voxels hold and
/// their min-max bricks.
double memory_to_render(const std::array<int, 3>& dims, double held_bytes);

/// What is known of an input from its header alone, as JSON.
nlohmann::json header_report(const ReadResult& input, const Volume& volume,
                             double memory_to_render);

/// What `info --json` prints of an input.
nlohmann::json input_report(const ReadResult& input, const ValueStatistics& values,
                            const std::vector<SuggestedIso>& suggested);

}  // namespace isolux
