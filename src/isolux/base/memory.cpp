#include "isolux/base/memory.h"

#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdio>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"

namespace isolux {

namespace {

double machine_bytes() {
  return static_cast<double>(::sysconf(_SC_PHYS_PAGES)) *
         static_cast<double>(::sysconf(_SC_PAGESIZE));
}

std::optional<double> chosen_limit;
std::atomic<std::size_t> held_bytes = 0;

double memory_limit() { return chosen_limit.value_or(0.8 * machine_bytes()); }

}  // namespace

void set_memory_limit(std::optional<double> bytes) { chosen_limit = bytes; }

bool memory_limit_is_set() { return chosen_limit.has_value(); }

std::optional<double> parse_memory(std::string_view text) {
  double unit = 1;
  const std::size_t suffix = std::string_view("kMGT").find(text.empty() ? ' ' : text.back());
  if (text.ends_with('%')) {
    unit = machine_bytes() / 100;
  } else if (suffix != std::string_view::npos) {
    unit = std::pow(1000.0, static_cast<double>(suffix) + 1);
  }
  if (unit != 1) text.remove_suffix(1);
  const auto number = parse_number(text);
  if (!number || *number <= 0) return std::nullopt;
  return *number * unit;
}

void check_memory(double bytes, const std::string& what) {
  const auto held = static_cast<double>(held_bytes.load());
  if (held + bytes <= memory_limit()) return;
  throw WorkError(
      what,
      "needs " + bytes_text(bytes) + " of memory" +
          (held > 0 ? " beside the " + bytes_text(held) + " that data hold already" : ""),
      "the limit is " + bytes_text(memory_limit()) + ", set by --max-memory");
}

HeldMemory::HeldMemory(std::size_t bytes) : bytes_(bytes) { held_bytes += bytes_; }

HeldMemory::~HeldMemory() { held_bytes -= bytes_; }

std::string bytes_text(double bytes) {
  constexpr const char* kUnits[] = {"bytes", "kB", "MB", "GB", "TB", "PB", "EB"};
  int unit = 0;
  while (bytes >= 1000 && unit < 6) {
    bytes /= 1000;
    ++unit;
  }
  char text[64];
  std::snprintf(text, sizeof text, unit == 0 ? "%.0f %s" : "%.3g %s", bytes, kUnits[unit]);
  return text;
}

}  // namespace isolux
