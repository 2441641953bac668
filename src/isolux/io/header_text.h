#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace isolux {

/// Without blanks and line ends at either end.
std::string trimmed(std::string_view text);

/// The words between blanks.
std::vector<std::string> words(const std::string& text);

}  // namespace isolux
