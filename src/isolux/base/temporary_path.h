#pragma once

#include <string>

namespace isolux {

/// A new file, or a new folder of files, that does not outlive its use: it goes when this does, and
/// also when the program is ended by a signal (interrupt, terminate, hang-up) or by a mapped file
/// that shrank. Where one of these signals is ignored, as under nohup, it stays ignored.
class TemporaryPath {
 public:
  /// A new, empty file that only its owner may read. `pattern` ends in XXXXXX, for letters by which
  /// it is new.
  static TemporaryPath new_file(const std::string& pattern);
  /// A new, empty folder of the same kind; it is to hold files only, no folders.
  static TemporaryPath new_folder(const std::string& pattern);

  ~TemporaryPath();
  TemporaryPath(TemporaryPath&& other) noexcept;
  TemporaryPath(const TemporaryPath&) = delete;
  TemporaryPath& operator=(const TemporaryPath&) = delete;

  const std::string& path() const { return path_; }
  /// 0 where it could be made, else the error's number; nothing is at path() then.
  int error() const { return error_; }
  /// The file, open for writing; -1 for a folder. Whoever takes it closes it.
  int descriptor() const { return descriptor_; }
  /// What is at path() has become something else, and stays.
  void keep();

 private:
  struct Entry;
  friend void remove_temporary_paths();
  TemporaryPath(std::string pattern, bool is_folder);

  std::string path_;
  int error_ = 0;
  int descriptor_ = -1;
  Entry* entry_ = nullptr;  // in the list that signal handlers look at
};

/// A new folder in the machine's place for temporary files, for a purpose that its name tells.
/// @param what  what it is made for, for the error.
/// @throws WorkError  where none can be made.
TemporaryPath temporary_folder(const std::string& purpose, const std::string& what);

/// Removes all that there are now. May be called in a signal handler that ends the program.
void remove_temporary_paths();

}  // namespace isolux
