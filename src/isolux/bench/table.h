#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "isolux/bench/work.h"

namespace isolux {

/// Measurements of one subject, such as one isosurface of one volume.
struct Section {
  std::string subject;
  std::vector<Measurement> measurements;
};

/// A whole run, and what it ran on.
struct Report {
  int width = 0;
  int height = 0;
  int threads = 0;
  std::string processor;
  double load_before = -1;
  double load_after = -1;
  std::vector<Section> sections;
};

/// For a person: work, median, 99th percentile, unit; below each work what it is compared with and
/// how many times as fast isolux is: the median over pairs of turns.
std::string report_text(const Report& report);

/// For a program: the same numbers, as a list of rows.
nlohmann::json report_json(const Report& report);

}  // namespace isolux
