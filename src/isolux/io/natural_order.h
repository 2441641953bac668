#pragma once

#include <string>

namespace isolux {

/// Whether name `a` comes before `b` where runs of digits count as numbers: slice2 before slice10.
bool comes_before(const std::string& a, const std::string& b);

}  // namespace isolux
