#include "isolux/base/number_text.h"

#include <charconv>
#include <cmath>

namespace isolux {
namespace {

template <typename... Format>
std::string with_to_chars(double value, Format... format) {
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, format...).ptr;
  return {buffer, end};
}

template <typename Number>
std::optional<Number> parse_all(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

}  // namespace

std::string to_text(double value) { return with_to_chars(value == 0 ? 0.0 : value); }

std::string to_text9(double value) {
  return with_to_chars(value == 0 ? 0.0 : value, std::chars_format::general, 9);
}

std::optional<double> parse_number(std::string_view text) {
  const std::optional<double> value = parse_all<double>(text);
  if (!value || !std::isfinite(*value)) return std::nullopt;
  return value;
}

std::optional<long long> parse_whole_number(std::string_view text) {
  return parse_all<long long>(text);
}

}  // namespace isolux
