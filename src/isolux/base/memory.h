#pragma once

#include <cstdint>
#include <string>

namespace isolux {

/// Asked before anything large is allocated.
/// @throws WorkError  where `bytes` exceed 80 % of the machine's memory; `what` needs them.
void check_memory(double bytes, const std::string& what);

/// 14811136 -> "14.8 MB".
std::string bytes_text(double bytes);

}  // namespace isolux
