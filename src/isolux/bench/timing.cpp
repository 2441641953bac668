#include "isolux/bench/timing.h"

#include <algorithm>
#include <chrono>
#include <fstream>

namespace isolux {

double milliseconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
      .count();
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t above = values.size() / 2;
  const std::size_t below = (values.size() - 1) / 2;
  return (values[below] + values[above]) / 2;
}

double percentile_99(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t rank = (99 * values.size() + 99) / 100;  // 99 % of them, rounded up
  return values[rank - 1];
}

double load_average() {
  double load = -1;
  std::ifstream("/proc/loadavg") >> load;
  return load;
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return {};
}

}  // namespace isolux
