#pragma once

#include <cstddef>
#include <string>

namespace isolux {

/// A file's bytes as memory, without reading them first: pages come from the file when they are
/// touched, and the system may drop them again, so they count as no memory of ours.
///
/// Where somebody cuts the file short, or the disk fails, the pages that are gone cannot be had any
/// more, and touching one would be a bare crash (SIGBUS). Instead the program then says in one line
/// which file it was, and ends with exit status 1.
class MappedFile {
 public:
  /// @throws WorkError  where the file cannot be opened or mapped, or is empty.
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  const char* data() const { return data_; }
  std::size_t size() const { return size_; }

 private:
  const char* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace isolux
