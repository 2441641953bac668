#pragma once

#include <filesystem>
#include <string>

namespace isolux {

/// A new private folder that goes, with all in it, when this does.
class ScratchFolder {
 public:
  /// @param purpose  part of its name; @param what  what it is made for, for the error.
  /// @throws WorkError  where none can be made.
  ScratchFolder(const std::string& purpose, const std::string& what);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace isolux
