#include "isolux/base/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "isolux/base/error.h"
#include "isolux/base/temporary_path.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

WorkError cannot_write(const std::string& path, int error, const char* hint) {
  return {path, std::string("cannot write: ") + std::strerror(error), hint};
}

// Where the file really lies: the end of a chain of symbolic links.
fs::path real_place(const std::string& path) {
  std::error_code error;
  const fs::path real = fs::canonical(path, error);
  return error ? fs::path(path) : real;
}

fs::path folder_of(const fs::path& file) {
  return file.parent_path().empty() ? fs::path(".") : file.parent_path();
}

// A new, empty file in the folder where `place` lies or is to lie.
TemporaryPath temporary_beside(const std::string& path, const fs::path& place) {
  TemporaryPath file = TemporaryPath::new_file((folder_of(place) / ".isolux-XXXXXX").string());
  if (file.error() == 0) return file;
  throw cannot_write(path, file.error(), "choose another place for the output");
}

bool is_device(const fs::path& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

// Writes everything and closes; returns 0 or the error's number.
int write_and_close(int file, std::string_view bytes) {
  int error = 0;
  while (!bytes.empty() && error == 0) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (::close(file) != 0 && error == 0) error = errno;
  return error;
}

mode_t mode_for(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) return status.st_mode & 07777;
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return 0666 & ~mask;
}

}  // namespace

void check_writable(const std::string& path) {
  const fs::path place = real_place(path);
  std::error_code error;
  if (path.empty()) throw WorkError(path, "is no file name", "give a file name");
  if (fs::is_directory(place, error)) {
    throw WorkError(path, "cannot write: it is a folder", "give a file name");
  }
  if (is_device(place)) return;
  if (fs::exists(place, error) && ::access(place.c_str(), W_OK) != 0) {
    throw cannot_write(path, errno, "choose another place for the output");
  }
  ::close(temporary_beside(path, place).descriptor());
}

void write_whole_file(const std::string& path, std::string_view bytes) {
  check_writable(path);
  const fs::path place = real_place(path);
  if (is_device(place)) {
    const int file = ::open(place.c_str(), O_WRONLY | O_CLOEXEC);
    const int error = file < 0 ? errno : write_and_close(file, bytes);
    if (error != 0) throw cannot_write(path, error, "is there room on the device?");
    return;
  }
  TemporaryPath beside = temporary_beside(path, place);
  ::fchmod(beside.descriptor(), mode_for(place));
  int error = write_and_close(beside.descriptor(), bytes);
  if (error == 0 && ::rename(beside.path().c_str(), place.c_str()) != 0) error = errno;
  if (error != 0) throw cannot_write(path, error, "is there room on the device?");
  beside.keep();
}

}  // namespace isolux
