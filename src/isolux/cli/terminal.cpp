#include "isolux/cli/terminal.h"

#include <unistd.h>

#include <iostream>

namespace isolux {

ProgressListener progress_bar(const Arguments& arguments) {
  if (!::isatty(STDERR_FILENO) && !arguments.has("progress")) return {};
  return [](const std::string& label, double share) {
    constexpr int kWidth = 40;
    const int filled = static_cast<int>(share * kWidth);
    std::string line = "\r" + label + " [" + std::string(static_cast<std::size_t>(filled), '#') +
                       std::string(static_cast<std::size_t>(kWidth - filled), ' ') + "] " +
                       std::to_string(static_cast<int>(100 * share)) + " %";
    if (share >= 1) line = "\r" + std::string(line.size(), ' ') + "\r";
    std::cerr << line << std::flush;
  };
}

void tell(const std::string& text) { std::cerr << "isolux: " << text << "\n"; }

void warn(const std::string& text) { std::cerr << "isolux: warning: " << text << "\n"; }

void tell_notes(const ReadResult& input) {
  for (const std::string& note : input.notes) {
    std::cerr << "isolux: " << input.name << ": " << note << "\n";
  }
}

}  // namespace isolux
