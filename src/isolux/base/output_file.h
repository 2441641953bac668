#pragma once

#include <string>
#include <string_view>

namespace isolux {

/// Makes sure, before long work begins, that a file could be written at `path`.
/// @throws WorkError  where its folder is missing or not writable, or it is a folder itself.
void check_writable(const std::string& path);

/// Writes the whole of `bytes`, or leaves whatever was at `path` as it was: into a new file beside
/// it, which then takes its place. Devices and pipes are written directly.
/// @throws WorkError  where that fails.
void write_whole_file(const std::string& path, std::string_view bytes);

}  // namespace isolux
