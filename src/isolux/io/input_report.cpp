#include "isolux/io/input_report.h"

#include <nlohmann/json.hpp>

#include "isolux/volume/brick_grid.h"

namespace isolux {

using nlohmann::json;

namespace {

json numbers(Vec3 v) { return {v.x, v.y, v.z}; }

}  // namespace

double memory_to_render(const std::array<int, 3>& dims, double held_bytes) {
  return held_bytes + BrickGrid::bytes(dims);
}

json header_report(const ReadResult& input, const Volume& volume, double memory_to_render) {
  json object = {{"kind", "volume"},
                 {"input", input.name},
                 {"format", input.format},
                 {"dims", volume.dims},
                 {"spacing", numbers(spacing_mm(volume))},
                 {"origin", numbers(volume.world_from_index.offset)},
                 {"memory_to_render", memory_to_render},
                 {"files", input.files},
                 {"notes", input.notes}};
  const Mat3 unit = direction(volume);
  object["direction"] = json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) object["direction"].push_back(unit.at(row, column));
  }
  if (!volume.modality.empty()) object["modality"] = volume.modality;
  if (!volume.units.empty()) object["units"] = volume.units;
  return object;
}

json input_report(const ReadResult& input, const ValueStatistics& values,
                  const std::vector<SuggestedIso>& suggested) {
  const Volume& volume = *input.volume;
  json object = header_report(
      input, volume, memory_to_render(volume.dims, static_cast<double>(held_bytes(volume))));
  object["type"] = voxel_type_name(volume);
  object["bytes"] = voxel_bytes(volume);
  object["min"] = values.min;
  object["max"] = values.max;
  object["not_finite"] = values.not_finite;
  object["suggested_iso"] = object["suggested_iso_names"] = json::array();
  for (const SuggestedIso& iso : suggested) {
    object["suggested_iso"].push_back(iso.value);
    object["suggested_iso_names"].push_back(iso.name);
  }
  return object;
}

}  // namespace isolux
