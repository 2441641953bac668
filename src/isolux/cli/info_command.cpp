#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/cli/command.h"
#include "isolux/cli/loaded_scene.h"
#include "isolux/cli/terminal.h"
#include "isolux/io/input_report.h"
#include "isolux/volume/statistics.h"

namespace isolux {
namespace {

using nlohmann::json;

std::string text_of(Vec3 v) { return to_text9(v.x) + ", " + to_text9(v.y) + ", " + to_text9(v.z); }

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
  const ValueStatistics values = value_statistics(*input.volume);
  const std::vector<SuggestedIso> suggested = suggest_iso(*input.volume, values);
  if (arguments.has("json")) {
    std::cout << input_report(input, values, suggested)
                     .dump(2, ' ', false, json::error_handler_t::replace)
              << "\n";
  } else {
    print_text(input, values, suggested);
  }
  return 0;
}

}  // namespace isolux
