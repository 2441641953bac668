#include "isolux/server/opened_inputs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "isolux/base/error.h"
#include "isolux/io/input_report.h"
#include "isolux/io/mesh_report.h"
#include "isolux/volume/statistics.h"

namespace isolux {
namespace {

using nlohmann::json;

constexpr int kMostDropped = 4;

json volume_report(const ReadResult& input) {
  const ValueStatistics values = value_statistics(*input.volume);
  json report = input_report(input, values, suggest_iso(*input.volume, values));
  report["histogram"] = values.histogram;
  const Affine& placed = input.volume->world_from_index;
  report["world_from_index"] = json::array();
  for (const Vec3& column :
       {placed.linear.column[0], placed.linear.column[1], placed.linear.column[2], placed.offset}) {
    report["world_from_index"].push_back({column.x, column.y, column.z});
  }
  return report;
}

json report_of(const ReadResult& input, bool dropped) {
  json report = input.mesh ? mesh_report(input) : volume_report(input);
  report["dropped"] = dropped;
  report.erase("files");
  return report;
}

}  // namespace

json reading_keys(const json& document) {
  json keys = json::object();
  for (const char* key : {"dims", "type", "spacing", "volume", "series", "crease"}) {
    if (document.contains(key)) keys[key] = document[key];
  }
  return keys;
}

std::string OpenedInputs::add(ReadResult input, const json& how, bool dropped) {
  Input added{std::move(input), how, dropped, {}, {}};
  if (dropped) added.checksums = isolux::checksums_of(added.read);
  const std::lock_guard lock(mutex_);
  const auto is_taken = [&](const std::string& name) {
    return std::ranges::any_of(inputs_, [&](const Input& one) { return one.read.name == name; });
  };
  const std::string own_name = added.read.name;
  for (int n = 2; dropped && is_taken(added.read.name); ++n) {
    added.read.name = own_name + " (" + std::to_string(n) + ")";
  }
  added.checksums.input = added.read.name;
  added.report = report_of(added.read, dropped);
  if (dropped && std::ranges::count(inputs_, true, &Input::dropped) == kMostDropped) {
    inputs_.erase(std::ranges::find(inputs_, true, &Input::dropped));
  }
  inputs_.push_back(std::move(added));
  return inputs_.back().read.name;
}

const OpenedInputs::Input& OpenedInputs::named(const std::string& name,
                                               const json& document) const {
  const auto found =
      std::ranges::find_if(inputs_, [&](const Input& one) { return one.read.name == name; });
  if (found == inputs_.end()) {
    throw WorkError(name, "is not open here", "drop the file on the page to open it");
  }
  if (found->how != reading_keys(document)) {
    throw UsageError(name, "the scene wants it read another way than it was",
                     "start `isolux view` with the scene's options");
  }
  return *found;
}

std::vector<SceneInput> OpenedInputs::inputs_of(const json& document) const {
  const std::lock_guard lock(mutex_);
  std::vector<SceneInput> inputs;
  for (const json& name : document.at("input")) {
    const ReadResult& read = named(name.get<std::string>(), document).read;
    inputs.push_back({read.volume, read.mesh});
  }
  return inputs;
}

std::vector<InputChecksums> OpenedInputs::checksums_of(const json& document) const {
  std::vector<Input> inputs;
  {
    const std::lock_guard lock(mutex_);
    for (const json& name : document.at("input")) {
      inputs.push_back(named(name.get<std::string>(), document));
    }
  }
  std::vector<InputChecksums> checksums;
  for (const Input& one : inputs) {
    checksums.push_back(one.dropped ? one.checksums : isolux::checksums_of(one.read));
  }
  return checksums;
}

json OpenedInputs::reports() const {
  const std::lock_guard lock(mutex_);
  json reports = json::array();
  for (const Input& one : inputs_) reports.push_back(one.report);
  return reports;
}

}  // namespace isolux
