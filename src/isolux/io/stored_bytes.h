#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "isolux/base/progress.h"

namespace isolux {

/// Bytes in a file, from an offset to its end, as they are or deflated (gzip or zlib).
struct StoredBytes {
  std::string path;
  std::uint64_t offset = 0;
  bool deflated = false;
};

/// Reads up to `count` bytes that stand behind the first `skip` (of the inflated ones, where
/// deflated), and returns how many there were. Nothing larger than a buffer is allocated.
/// @throws WorkError  where the file cannot be read, or its deflated bytes are damaged.
std::size_t read_bytes(const StoredBytes& from, std::uint64_t skip, char* to, std::size_t count,
                       const ProgressListener& listener = {});

/// The first bytes, at most `count`; fewer where the file ends.
std::string first_bytes(const StoredBytes& from, std::size_t count);

/// How large the file is, counted from the offset; 0 where that lies behind its end.
/// @throws WorkError  where there is no such file.
double stored_size(const StoredBytes& from);

}  // namespace isolux
