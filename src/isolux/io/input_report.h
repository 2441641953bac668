#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "isolux/io/reader.h"
#include "isolux/volume/statistics.h"

namespace isolux {

/// What drawing surfaces of a volume takes in bytes, beside the picture: the voxels and their
/// min-max bricks.
double memory_to_render(const Volume& volume);

/// What `info --json` prints of an input.
nlohmann::json input_report(const ReadResult& input, const ValueStatistics& values,
                            const std::vector<SuggestedIso>& suggested);

}  // namespace isolux
