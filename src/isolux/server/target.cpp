#include "isolux/server/target.h"

#include <charconv>

namespace isolux {
namespace {

constexpr std::size_t kLongestName = 200;

// "a%20b" -> "a b". What is no such escape stays.
std::string decoded(std::string_view text) {
  std::string plain;
  for (std::size_t n = 0; n < text.size(); ++n) {
    unsigned byte = 0;
    const char* digits = text.data() + n + 1;
    if (text[n] == '%' && n + 2 < text.size() &&
        std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
      plain += static_cast<char>(byte);
      n += 2;
    } else {
      plain += text[n];
    }
  }
  return plain;
}

}  // namespace

Target parse_target(std::string_view target) {
  const std::size_t question = target.find('?');
  Target parsed{std::string(target.substr(0, question)), {}};
  constexpr std::string_view kName = "name=";
  if (question != std::string_view::npos && target.substr(question + 1).starts_with(kName)) {
    parsed.name = decoded(target.substr(question + 1 + kName.size()));
  }
  return parsed;
}

std::string bare_file_name(std::string_view name) {
  const std::size_t slash = name.find_last_of("/\\");
  if (slash != std::string_view::npos) name.remove_prefix(slash + 1);
  std::string bare;
  for (const char c : name) {
    if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) bare += c;
  }
  // The end holds the suffix; a cut goes before a whole character.
  if (bare.size() > kLongestName) bare.erase(0, bare.size() - kLongestName);
  while (!bare.empty() && (static_cast<unsigned char>(bare[0]) & 0xc0) == 0x80) bare.erase(0, 1);
  return bare.empty() || bare == "." || bare == ".." ? "file" : bare;
}

}  // namespace isolux
