#include "isolux/io/natural_order.h"

#include <cctype>
#include <string_view>

namespace isolux {
namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// Takes the run of digits, or of other characters, at the front.
std::string_view take_run(std::string_view& text) {
  const bool digits = is_digit(text.front());
  std::size_t length = 0;
  while (length < text.size() && is_digit(text[length]) == digits) ++length;
  const std::string_view run = text.substr(0, length);
  text.remove_prefix(length);
  return run;
}

std::string_view without_zeros(std::string_view digits) {
  while (digits.size() > 1 && digits.front() == '0') digits.remove_prefix(1);
  return digits;
}

}  // namespace

bool comes_before(const std::string& a, const std::string& b) {
  std::string_view rest_a = a, rest_b = b;
  while (!rest_a.empty() && !rest_b.empty()) {
    const std::string_view run_a = take_run(rest_a), run_b = take_run(rest_b);
    if (is_digit(run_a.front()) && is_digit(run_b.front())) {
      const std::string_view number_a = without_zeros(run_a), number_b = without_zeros(run_b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
    } else if (run_a != run_b) {
      return run_a < run_b;
    }
  }
  return rest_a.empty() && (!rest_b.empty() || a < b);
}

}  // namespace isolux
