#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/cli/command.h"
#include "isolux/cli/loaded_scene.h"
#include "isolux/cli/mesh_info.h"
#include "isolux/cli/terminal.h"
#include "isolux/volume/brick_grid.h"
#include "isolux/volume/statistics.h"

namespace isolux {
namespace {

using nlohmann::json;

json numbers(Vec3 v) { return {v.x, v.y, v.z}; }

std::string text_of(Vec3 v) { return to_text9(v.x) + ", " + to_text9(v.y) + ", " + to_text9(v.z); }

// What drawing surfaces of it takes, beside the picture: the voxels and their min-max bricks.
double memory_to_render(const Volume& volume) {
  return static_cast<double>(voxel_bytes(volume)) + BrickGrid::bytes(volume.dims);
}

json as_json(const ReadResult& input, const ValueStatistics& values,
             const std::vector<SuggestedIso>& suggested) {
  const Volume& volume = *input.volume;
  json object = {{"kind", "volume"},
                 {"input", input.name},
                 {"format", input.format},
                 {"dims", volume.dims},
                 {"spacing", numbers(spacing_mm(volume))},
                 {"origin", numbers(volume.world_from_index.offset)},
                 {"type", voxel_type_name(volume)},
                 {"min", values.min},
                 {"max", values.max},
                 {"not_finite", values.not_finite},
                 {"bytes", voxel_bytes(volume)},
                 {"memory_to_render", memory_to_render(volume)},
                 {"files", input.files},
                 {"notes", input.notes}};
  const Mat3 unit = direction(volume);
  object["direction"] = json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) object["direction"].push_back(unit.at(row, column));
  }
  if (!volume.modality.empty()) object["modality"] = volume.modality;
  if (!volume.units.empty()) object["units"] = volume.units;
  object["suggested_iso"] = object["suggested_iso_names"] = json::array();
  for (const SuggestedIso& iso : suggested) {
    object["suggested_iso"].push_back(iso.value);
    object["suggested_iso_names"].push_back(iso.name);
  }
  return object;
}

// The histogram as blocks on a logarithmic scale, from the least value to the greatest, with a mark
// below each suggested iso value.
void print_histogram(const ValueStatistics& values, const std::vector<SuggestedIso>& suggested) {
  constexpr const char* kBlocks[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  constexpr std::size_t kColumns = 64;
  if (values.histogram.size() < kColumns) return;
  std::vector<double> columns(kColumns, 0);
  for (std::size_t bin = 0; bin < values.histogram.size(); ++bin) {
    columns[bin * kColumns / values.histogram.size()] += static_cast<double>(values.histogram[bin]);
  }
  const double highest = std::log1p(*std::ranges::max_element(columns));
  std::cout << "  histogram  ";
  for (const double count : columns) {
    // A column with anything in it shows at least the lowest block.
    const double height = std::ceil(8 * std::log1p(count) / highest);
    std::cout << kBlocks[static_cast<std::size_t>(height)];
  }
  std::string marks(kColumns, ' ');
  for (const SuggestedIso& iso : suggested) {
    const double place = (iso.value - values.min) / (values.max - values.min) * kColumns;
    marks[std::min(kColumns - 1, static_cast<std::size_t>(std::max(0.0, place)))] = '^';
  }
  std::cout << "\n             " << marks << "\n";
}

void print_text(const ReadResult& input, const ValueStatistics& values,
                const std::vector<SuggestedIso>& suggested) {
  const Volume& volume = *input.volume;
  const Vec3 spacing = spacing_mm(volume);
  const Mat3 unit = direction(volume);
  const std::string units = volume.units.empty() ? "" : " " + volume.units;
  std::cout << input.name << ": " << input.format
            << (volume.modality.empty() ? "" : ", " + volume.modality) << "\n"
            << "  voxels     " << volume.dims[0] << " x " << volume.dims[1] << " x "
            << volume.dims[2] << ", " << voxel_type_name(volume) << ", "
            << bytes_text(static_cast<double>(voxel_bytes(volume))) << "\n"
            << "  memory     " << bytes_text(memory_to_render(volume)) << " to render it\n"
            << "  spacing    " << to_text9(spacing.x) << " x " << to_text9(spacing.y) << " x "
            << to_text9(spacing.z) << " mm\n"
            << "  origin     " << text_of(volume.world_from_index.offset)
            << " mm (voxel 0, 0, 0; LPS)\n"
            << "  i runs to  " << text_of(unit.column[0]) << "\n"
            << "  j runs to  " << text_of(unit.column[1]) << "\n"
            << "  k runs to  " << text_of(unit.column[2]) << "\n"
            << "  values     " << to_text9(values.min) << " to " << to_text9(values.max) << units;
  if (values.not_finite > 0)
    std::cout << ", and " << values.not_finite << " voxels that are no number";
  std::cout << "\n  suggested ";
  for (const SuggestedIso& iso : suggested) {
    std::cout << " iso=" << to_text9(iso.value) << " (" << iso.name << ")";
  }
  std::cout << (suggested.empty() ? " none: all voxels have one value\n" : "\n");
  print_histogram(values, suggested);
  for (const std::string& note : input.notes) std::cout << "  note       " << note << "\n";
}

}  // namespace

int run_info(const Command&, const Arguments& arguments) {
  if (arguments.inputs.size() > 1) {
    throw UsageError("isolux info", "takes one INPUT", "ask for one file at a time");
  }
  const SceneDescription description = describe(document_from(arguments), "info");
  const ReadResult input = read_inputs(description, progress_bar(arguments)).front();
  if (input.mesh) {
    print_mesh_info(input, arguments.has("json"));
    return 0;
  }
  const ValueStatistics values = value_statistics(*input.volume);
  const std::vector<SuggestedIso> suggested = suggest_iso(*input.volume, values);
  if (arguments.has("json")) {
    std::cout
        << as_json(input, values, suggested).dump(2, ' ', false, json::error_handler_t::replace)
        << "\n";
  } else {
    print_text(input, values, suggested);
  }
  return 0;
}

}  // namespace isolux
