#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace isolux {

/// Lets check_memory allow this many bytes, instead of 80 % of the machine's memory.
void set_memory_limit(double bytes);

/// Whether set_memory_limit was called: the user has said how much it may be.
bool memory_limit_is_set();

/// "8G", "500M", "64k" (powers of 1000), "50%" of the machine's memory, or bytes; nothing where the
/// text is none of these.
std::optional<double> parse_memory(std::string_view text);

/// Asked before anything large is allocated.
/// @throws WorkError  where `bytes` exceed the limit; `what` needs them.
void check_memory(double bytes, const std::string& what);

/// 14811136 -> "14.8 MB".
std::string bytes_text(double bytes);

}  // namespace isolux
