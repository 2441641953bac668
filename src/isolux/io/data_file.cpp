#include "isolux/io/data_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"

namespace isolux {

namespace fs = std::filesystem;

namespace {

bool headers_are_trusted = false;

// Whether links lead from `place`, which is named below the folder, to somewhere else.
bool leads_out_of(const fs::path& folder, const fs::path& place) {
  std::error_code error;
  const fs::path root = fs::weakly_canonical(folder.empty() ? "." : folder, error);
  const fs::path steps = fs::weakly_canonical(place, error).lexically_relative(root);
  return error || steps.empty() || *steps.begin() == "..";
}

}  // namespace

void trust_headers() { headers_are_trusted = true; }

std::string data_file_beside(const std::string& header_path, const std::string& named) {
  const fs::path name(named);
  const bool steps_up = std::ranges::find(name, fs::path("..")) != name.end();
  if (named.empty() || (!headers_are_trusted && (name.is_absolute() || steps_up))) {
    throw WorkError(header_path, "names the data file '" + named + "'",
                    "a header may only name files beside or below itself, unless --trust is given");
  }
  const fs::path folder = fs::path(header_path).parent_path(), place = folder / name;
  std::error_code error;
  if (!fs::exists(place, error)) {
    throw WorkError(header_path, "its data file " + place.string() + " is not there",
                    "a header needs its data files beside or below it");
  }
  if (!headers_are_trusted && leads_out_of(folder, place)) {
    throw WorkError(header_path,
                    "its data file " + place.string() + " is a link to " +
                        fs::weakly_canonical(place, error).string(),
                    "a header may only name files beside or below itself, unless --trust is given");
  }
  return place.string();
}

std::vector<std::string> numbered_files(const std::string& pattern, long long first, long long last,
                                        long long step) {
  const std::size_t percent = pattern.find('%');
  if (percent == std::string::npos || step == 0) return {};
  const std::size_t d = pattern.find('d', percent);
  if (d == std::string::npos) return {};
  const std::string width_text = pattern.substr(percent + 1, d - percent - 1);
  const auto width = parse_whole_number(width_text.empty() ? "0" : width_text);
  constexpr long long kWidest = 20;
  if (!width || *width < 0 || *width > kWidest || width_text.starts_with('+')) return {};

  constexpr double kMostFiles = 1e6, kLargestNumber = 1e15;
  const double steps =
      (static_cast<double>(last) - static_cast<double>(first)) / static_cast<double>(step);
  const auto too_large = [](long long n) {
    return std::fabs(static_cast<double>(n)) > kLargestNumber;
  };
  if (too_large(first) || too_large(last) || !(steps >= 0 && steps < kMostFiles)) return {};
  std::vector<std::string> files;
  for (long long n = 0; n <= static_cast<long long>(steps); ++n) {
    std::string number = std::to_string(first + n * step);
    const auto wanted = static_cast<std::size_t>(*width);
    const char fill = width_text.starts_with('0') ? '0' : ' ';
    if (number.size() < wanted) number.insert(0, wanted - number.size(), fill);
    files.push_back(pattern.substr(0, percent) + number + pattern.substr(d + 1));
  }
  return files;
}

}  // namespace isolux
