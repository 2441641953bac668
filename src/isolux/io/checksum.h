#pragma once

#include <string>
#include <string_view>

namespace isolux {

/// The SHA-256 of a file as 64 hexadecimal digits, as `sha256sum` prints it.
/// @throws WorkError  where it cannot be read.
std::string sha256_of_file(const std::string& path);

}  // namespace isolux
