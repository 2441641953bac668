#include "isolux/base/mapped_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>

#include "isolux/base/error.h"
#include "isolux/base/temporary_path.h"

namespace isolux {
namespace {

// What the signal handler may look at while other threads map and unmap files: a list that only
// grows, of entries that are used again. An entry without an end is free.
struct Watched {
  std::atomic<const char*> begin = nullptr;
  std::atomic<const char*> end = nullptr;
  std::string line;  // what is to be said; not touched while the entry is in use
  Watched* next = nullptr;
};

std::atomic<Watched*> watched = nullptr;
std::mutex changing_watched;
struct sigaction earlier_action;

void on_bus_error(int, siginfo_t* info, void*) {
  const char* const at = static_cast<const char*>(info->si_addr);
  for (const Watched* one = watched; one != nullptr; one = one->next) {
    const char* const end = one->end;
    if (end == nullptr || at < one->begin || at >= end) continue;
    [[maybe_unused]] const ssize_t told = ::write(2, one->line.data(), one->line.size());
    remove_temporary_paths();
    ::_exit(1);
  }
  ::sigaction(SIGBUS, &earlier_action, nullptr);  // none of ours: it comes again, to that one
}

// The handler has to stand before the first touch; the line is made now, since a handler may not
// allocate.
void watch(const std::string& path, const char* begin, std::size_t size) {
  const std::lock_guard lock(changing_watched);
  Watched* entry = watched;
  while (entry != nullptr && entry->end != nullptr) entry = entry->next;
  if (entry == nullptr) {
    if (watched == nullptr) {
      struct sigaction action {};
      action.sa_sigaction = on_bus_error;
      action.sa_flags = SA_SIGINFO;
      ::sigaction(SIGBUS, &action, &earlier_action);
    }
    entry = new Watched;
    entry->next = watched;
    watched = entry;
  }
  const WorkError error(path, "was cut short, or its disk failed, while it was in use",
                        "leave a file alone until isolux is done with it");
  entry->line =
      (::isatty(2) ? "\nisolux: error: " : "isolux: error: ") + std::string(error.what()) + "\n";
  entry->begin = begin;
  entry->end = begin + size;
}

void unwatch(const char* begin) {
  const std::lock_guard lock(changing_watched);
  for (Watched* entry = watched; entry != nullptr; entry = entry->next) {
    if (entry->begin == begin) entry->end = nullptr;
  }
}

WorkError cannot_map(const std::string& path, int error) {
  return {path, std::string("cannot be read: ") + std::strerror(error), "check its permissions"};
}

}  // namespace

MappedFile::MappedFile(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) throw cannot_map(path, errno);
  struct stat status {};
  const bool is_file = ::fstat(file, &status) == 0 && S_ISREG(status.st_mode);
  if (!is_file || status.st_size == 0) {
    ::close(file);
    throw WorkError(path, "is empty or no file", "check the name");
  }
  size_ = static_cast<std::size_t>(status.st_size);
  void* const mapped = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
  const int error = errno;
  ::close(file);
  if (mapped == MAP_FAILED) throw cannot_map(path, error);
  data_ = static_cast<const char*>(mapped);
  watch(path, data_, size_);
}

MappedFile::~MappedFile() {
  unwatch(data_);
  ::munmap(const_cast<char*>(data_), size_);
}

}  // namespace isolux
