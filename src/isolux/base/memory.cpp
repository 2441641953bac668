#include "isolux/base/memory.h"

#include <unistd.h>

#include <cstdio>

#include "isolux/base/error.h"

namespace isolux {

void check_memory(double bytes, const std::string& what) {
  constexpr double kShare = 0.8;
  const double machine =
      static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (bytes > kShare * machine) {
    throw WorkError(what, "needs " + bytes_text(bytes) + " of memory",
                    "this machine has " + bytes_text(machine));
  }
}

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
