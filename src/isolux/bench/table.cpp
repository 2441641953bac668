#include "isolux/bench/table.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "isolux/bench/timing.h"

namespace isolux {
namespace {

using nlohmann::json;

// A time as it is, or the rate that it makes with so many rays. The 99th percentile is that of the
// times: of a rate, what 99 % of the turns reach.
struct Shown {
  double median;
  double p99;
  const char* unit;
};

Shown shown(const std::vector<double>& ms, double rays) {
  const double middle = median(ms), slow = percentile_99(ms);
  if (rays == 0) return {middle, slow, "ms"};
  return {rays / middle / 1e3, rays / slow / 1e3, "M rays/s"};
}

std::string line_of(const std::string& name, const Shown& numbers, const std::string& rest) {
  char line[200];
  std::snprintf(line, sizeof line, "%-42.42s %10.2f %10.2f  %-8s  %s\n", name.c_str(),
                numbers.median, numbers.p99, numbers.unit, rest.c_str());
  return line;
}

std::string times(double ratio) {
  char text[40];
  std::snprintf(text, sizeof text, "%6.2f x", ratio);
  return text;
}

json numbers_json(const std::vector<double>& ms, double rays) {
  const Shown numbers = shown(ms, rays);
  return {{"median", numbers.median},
          {"p99", numbers.p99},
          {"unit", numbers.unit},
          {"turns", ms.size()}};
}

std::string section_text(const Section& section) {
  char head[200];
  std::snprintf(head, sizeof head, "%-42.42s %10s %10s  %-8s  %s\n", section.subject.c_str(),
                "median", "p99", "unit", "isolux is faster by");
  std::string text = head;
  for (const Measurement& row : section.measurements) {
    text += line_of(row.work, shown(row.ms, row.rays), row.note);
    for (const Comparison& other : row.comparisons) {
      text += line_of("  " + other.name, shown(other.ms, row.rays),
                      times(median(other.ratios)) + "  " + other.note);
    }
  }
  return text + "\n";
}

json row_json(const std::string& subject, const Measurement& row) {
  json one = numbers_json(row.ms, row.rays);
  one["subject"] = subject;
  one["work"] = row.work;
  one["load_average"] = row.load;
  if (!row.note.empty()) one["note"] = row.note;
  one["against"] = json::array();
  for (const Comparison& other : row.comparisons) {
    json against = numbers_json(other.ms, row.rays);
    against["name"] = other.name;
    against["ratio"] = median(other.ratios);
    if (!other.note.empty()) against["note"] = other.note;
    one["against"].push_back(against);
  }
  return one;
}

}  // namespace

std::string report_text(const Report& report) {
  std::string text;
  for (const Section& section : report.sections) text += section_text(section);
  char last[300];
  std::snprintf(last, sizeof last, "%dx%d, %d %s, %s, load average %.2f before and %.2f after\n",
                report.width, report.height, report.threads,
                report.threads == 1 ? "thread" : "threads", report.processor.c_str(),
                report.load_before, report.load_after);
  return text + last;
}

json report_json(const Report& report) {
  json rows = json::array();
  for (const Section& section : report.sections) {
    for (const Measurement& row : section.measurements) {
      rows.push_back(row_json(section.subject, row));
    }
  }
  return {{"width", report.width},
          {"height", report.height},
          {"threads", report.threads},
          {"processor", report.processor},
          {"load_average_before", report.load_before},
          {"load_average_after", report.load_after},
          {"rows", rows}};
}

}  // namespace isolux
