#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "isolux/base/progress.h"

namespace isolux {

/// Bytes in a file, from an offset to its end, as they are, deflated (gzip or zlib), or as bzip2.
struct StoredBytes {
  std::string path;
  std::uint64_t offset = 0;
  bool deflated = false;
  bool bzip2 = false;
};

/// Reads up to `count` bytes that stand behind the first `skip` (of the inflated ones, where
/// deflated), and returns how many there were. Nothing larger than a buffer is allocated.
/// @throws WorkError  where the file cannot be read, or its deflated bytes are damaged.
std::size_t read_bytes(const StoredBytes& from, std::uint64_t skip, char* to, std::size_t count);

/// `bytes` of a file behind the first `skip` (of the inflated ones, where deflated): one piece of a
/// volume's voxels.
struct Stretch {
  StoredBytes file;
  std::uint64_t skip = 0;
  std::uint64_t bytes = 0;
};

/// Inflates, and forgets, what a very large promise (1 GB and more) is said to be made of, so that
/// memory is only taken for it where it is there. Does nothing for stretches that are not deflated.
/// @throws WorkError  where a stretch is shorter than promised, or damaged.
void check_large_stretches(const std::vector<Stretch>& stretches);

/// Reads stretches from their first byte on, one behind the other.
class StretchReader {
 public:
  StretchReader(std::vector<Stretch> stretches, const ProgressListener& listener);
  ~StretchReader();
  StretchReader(StretchReader&&) noexcept;

  /// The next `count` bytes.
  /// @throws WorkError  where a stretch is shorter than promised, damaged, or cannot be read.
  void read(char* to, std::size_t count);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The first bytes, at most `count`; fewer where the file ends.
std::string first_bytes(const StoredBytes& from, std::size_t count);

/// How large the file is, counted from the offset; 0 where that lies behind its end.
/// @throws WorkError  where there is no such file.
double stored_size(const StoredBytes& from);

}  // namespace isolux
