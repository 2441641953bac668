#include "isolux/io/dicom_series.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/io/dicom_signature.h"
#include "isolux/io/format.h"
#include "isolux/io/natural_order.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

bool is_dicom(const fs::directory_entry& entry) {
  std::error_code error;
  if (!entry.is_regular_file(error)) return false;
  std::ifstream file(entry.path(), std::ios::binary);
  if (!file) {  // it could be a slice: leaving it out in silence would draw another volume
    throw WorkError(entry.path().string(), std::string("cannot be read: ") + std::strerror(errno),
                    "check its permissions");
  }
  std::string bytes(512, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return dicom_start(bytes).has_value();
}

void find_below(const fs::path& folder, int depth, std::vector<std::string>& found) {
  std::error_code error;
  std::vector<fs::path> folders;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (is_dicom(entry)) {
      found.push_back(entry.path().string());
    } else if (depth > 0 && entry.is_directory(error)) {
      folders.push_back(entry.path());
    }
  }
  if (depth == 0 || (depth == kDicomFolderDepth && !found.empty())) return;
  for (const fs::path& below : folders) find_below(below, depth - 1, found);
}

std::string description(const DicomSeries& series) {
  const DicomFile& first = series.first();
  long long frames = 0;
  for (const DicomFile& file : series.files) frames += file.frame_count;
  std::string text = first.description.empty() ? "" : "'" + first.description + "', ";
  text += (first.modality.empty() ? "?" : first.modality) + ", " + std::to_string(first.columns) +
          "x" + std::to_string(first.rows) + "x" + std::to_string(frames);
  if (!first.date.empty()) text += ", " + first.date;
  return text;
}

}  // namespace

std::vector<std::string> find_dicom_files(const std::string& folder) {
  std::vector<std::string> found;
  find_below(folder, kDicomFolderDepth, found);
  std::ranges::sort(found, comes_before);
  return found;
}

const DicomFile& DicomSeries::first() const {
  const auto sound = std::ranges::find_if(files, [](const auto& f) { return f.fault.empty(); });
  return sound == files.end() ? files.front() : *sound;
}

double DicomSeries::voxel_count() const {
  double count = 0;
  for (const DicomFile& file : files) {
    if (file.samples == 1 && file.fault.empty()) count += file.voxel_count();
  }
  return count;
}

std::vector<DicomSeries> series_among(std::vector<DicomFile> files) {
  std::map<std::pair<int, std::string>, DicomSeries> by_number;
  for (DicomFile& file : files) {
    if (!file.has_image()) continue;
    by_number[{file.series_number, file.series_uid}].files.push_back(std::move(file));
  }
  std::vector<DicomSeries> all;
  for (auto& [number, series] : by_number) {
    if (series.first().fault.empty()) all.push_back(std::move(series));
  }
  return all;
}

std::string series_list(const std::vector<DicomSeries>& series) {
  std::string list;
  for (std::size_t n = 0; n < series.size(); ++n) {
    list += (n == 0 ? "" : "; ") + std::to_string(n + 1) + ": " + description(series[n]);
  }
  return list;
}

std::size_t chosen_series(const std::vector<DicomSeries>& series, const std::string& choice) {
  const auto number = parse_whole_number(choice);
  if (number && *number >= 1 && *number <= static_cast<long long>(series.size())) {
    return static_cast<std::size_t>(*number - 1);
  }
  for (std::size_t n = 0; n < series.size(); ++n) {
    if (series[n].first().series_uid == choice) return n;
  }
  throw UsageError("--series", "'" + choice + "' is none of " + series_list(series),
                   "give a number of this list, or a SeriesInstanceUID");
}

std::size_t largest_series(const std::vector<DicomSeries>& series) {
  const auto largest = std::ranges::max_element(series, {}, &DicomSeries::voxel_count);
  return static_cast<std::size_t>(largest - series.begin());
}

}  // namespace isolux
