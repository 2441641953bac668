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
#include "isolux/io/input_report.h"
#include "isolux/volume/statistics.h"

namespace isolux {
namespace {

using nlohmann::json;

std::string text_of(Vec3 v) { return to_text9(v.x) + ", " + to_text9(v.y) + ", " + to_text9(v.z); }

// What is known of an input: from its header, or from its voxels as well.
struct Facts {
  const Volume& volume;
  const ReadResult& input;
  std::string type;    // of the voxels; where they are not read, of the numbers in the file
  double voxel_bytes;  // where they are not read, at the most
  double held_bytes;   // of memory; 0 where they are mapped from the file
};

double memory_to_render(const Facts& facts) {
  return isolux::memory_to_render(facts.volume.dims, facts.held_bytes);
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

void print_header(const Facts& facts) {
  const Volume& volume = facts.volume;
  const Vec3 spacing = spacing_mm(volume);
  const Mat3 unit = direction(volume);
  std::cout << facts.input.name << ": " << facts.input.format
            << (volume.modality.empty() ? "" : ", " + volume.modality) << "\n"
            << "  voxels     " << volume.dims[0] << " x " << volume.dims[1] << " x "
            << volume.dims[2] << ", " << facts.type << ", " << bytes_text(facts.voxel_bytes) << "\n"
            << "  memory     " << bytes_text(memory_to_render(facts)) << " to render it"
            << (facts.held_bytes == 0 ? "; its voxels stay in the file" : "") << "\n"
            << "  spacing    " << to_text9(spacing.x) << " x " << to_text9(spacing.y) << " x "
            << to_text9(spacing.z) << " mm\n"
            << "  origin     " << text_of(volume.world_from_index.offset)
            << " mm (voxel 0, 0, 0; LPS)\n"
            << "  i runs to  " << text_of(unit.column[0]) << "\n"
            << "  j runs to  " << text_of(unit.column[1]) << "\n"
            << "  k runs to  " << text_of(unit.column[2]) << "\n";
}

void print_values(const Facts& facts, const ValueStatistics& values,
                  const std::vector<SuggestedIso>& suggested) {
  const std::string& units = facts.volume.units;
  std::cout << "  values     " << to_text9(values.min) << " to " << to_text9(values.max)
            << (units.empty() ? "" : " " + units);
  if (values.not_finite > 0)
    std::cout << ", and " << values.not_finite << " voxels that are no number";
  std::cout << "\n  suggested ";
  for (const SuggestedIso& iso : suggested) {
    std::cout << " iso=" << to_text9(iso.value) << " (" << iso.name << ")";
  }
  std::cout << (suggested.empty() ? " none: all voxels have one value\n" : "\n");
  print_histogram(values, suggested);
}

void print_notes(const Facts& facts) {
  for (const std::string& note : facts.input.notes) std::cout << "  note       " << note << "\n";
}

void print_json(const json& object) {
  std::cout << object.dump(2, ' ', false, json::error_handler_t::replace) << "\n";
}

// What the header alone tells, among it the memory that it would take to go on.
void tell_header(const OpenedInput& opened, bool in_json) {
  const Facts facts{opened.volume, opened.result, "stored as " + opened.stored_type,
                    opened.voxel_count() * opened.bytes_per_voxel_most, opened.voxel_memory()};
  if (in_json) {
    json object = header_report(opened.result, opened.volume, memory_to_render(facts));
    object["stored_type"] = opened.stored_type;
    print_json(object);
    return;
  }
  print_header(facts);
  print_notes(facts);
}

}  // namespace

int run_info(const Command&, const Arguments& arguments) {
  if (arguments.inputs.size() > 1) {
    throw UsageError("isolux info", "takes one INPUT", "ask for one file at a time");
  }
  const SceneDescription description = describe(document_from(arguments), "info");
  const ProgressListener listener = progress_bar(arguments);
  if (arguments.has("header")) {
    const OpenedInput opened = open_inputs(description, listener).front();
    opened.result.mesh ? print_mesh_info(opened.result, arguments.has("json"))
                       : tell_header(opened, arguments.has("json"));
    return 0;
  }
  ReadResult input = read_inputs(description, listener).front();
  if (input.mesh) {
    print_mesh_info(input, arguments.has("json"));
    return 0;
  }
  const Volume& volume = *input.volume;
  const Facts facts{volume, input, voxel_type_name(volume),
                    static_cast<double>(voxel_bytes(volume)),
                    static_cast<double>(held_bytes(volume))};
  const ValueStatistics values = value_statistics(volume);
  const std::vector<SuggestedIso> suggested = suggest_iso(volume, values);
  if (!suggested.empty() && suggested[0].name == "labels") {
    input.notes.push_back(
        "its values are labels, or look like it: iso=0.5 bounds all of them; between two labels "
        "there is no surface to measure");
  }
  if (arguments.has("json")) {
    print_json(input_report(input, values, suggested));
  } else {
    print_header(facts);
    print_values(facts, values, suggested);
    print_notes(facts);
  }
  return 0;
}

}  // namespace isolux
