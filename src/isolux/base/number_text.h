#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace isolux {

/// The shortest decimal text that reads back as the same double: 0.1, 300, 1e-07.
std::string to_text(double value);

/// `value` with nine significant digits, trailing zeros dropped.
std::string to_text9(double value);

/// The whole of `text` as a finite number, or nothing. No locale, no leading or trailing blanks;
/// a leading '+' is taken.
std::optional<double> parse_number(std::string_view text);

/// The whole of `text` as a whole number, or nothing.
std::optional<long long> parse_whole_number(std::string_view text);

}  // namespace isolux
