#include "isolux/base/temporary_path.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <utility>

#include "isolux/base/error.h"

namespace isolux {

// The list only grows; entries are used again. A handler may look at it at any time, so `is_there`
// is set last and cleared first.
struct TemporaryPath::Entry {
  std::atomic<bool> is_there = false;
  std::string path;
  bool is_folder = false;
  Entry* next = nullptr;
  static inline std::atomic<Entry*> first = nullptr;
};

namespace {

constexpr int kEndingSignals[] = {SIGINT, SIGTERM, SIGHUP};
std::mutex changing_list;

// As the kernel hands out the names in a folder (getdents64); readdir may allocate, which a signal
// handler must not.
struct FolderRecord {
  std::uint64_t inode;
  std::int64_t offset;
  std::uint16_t length;
  std::uint8_t type;
  char name[1];
};

void remove_files_in(const char* path) {
  const int folder = ::open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  alignas(FolderRecord) char records[4096];
  long got = 0;
  while ((got = ::syscall(SYS_getdents64, folder, records, sizeof records)) > 0) {
    for (long at = 0; at < got;) {
      const auto* const record = reinterpret_cast<const FolderRecord*>(records + at);
      ::unlinkat(folder, record->name, 0);  // "." and ".." are refused, as they should be
      at += record->length;
    }
  }
  ::close(folder);
}

// Another thread may be at work in a folder, and add a file to it meanwhile.
void remove_folder(const char* path) {
  constexpr int kMostTries = 1000;
  for (int n = 0; n < kMostTries; ++n) {
    remove_files_in(path);
    if (::rmdir(path) == 0 || errno != ENOTEMPTY) return;
  }
}

void on_ending_signal(int signal) {
  remove_temporary_paths();
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

void handle_ending_signals() {
  for (const int signal : kEndingSignals) {
    struct sigaction action {};
    ::sigaction(signal, nullptr, &action);
    const bool is_default = (action.sa_flags & SA_SIGINFO) == 0 && action.sa_handler == SIG_DFL;
    if (!is_default) continue;  // ignored, or somebody else's, who ends in an orderly way
    action.sa_handler = on_ending_signal;
    ::sigaction(signal, &action, nullptr);
  }
}

}  // namespace

TemporaryPath::TemporaryPath(std::string pattern, bool is_folder) : path_(std::move(pattern)) {
  const std::lock_guard lock(changing_list);
  // No signal between the making and the noting of it.
  sigset_t ending, before;
  ::sigemptyset(&ending);
  for (const int signal : kEndingSignals) ::sigaddset(&ending, signal);
  ::pthread_sigmask(SIG_BLOCK, &ending, &before);
  if (is_folder) {
    error_ = ::mkdtemp(path_.data()) ? 0 : errno;
  } else {
    descriptor_ = ::mkostemp(path_.data(), O_CLOEXEC);
    error_ = descriptor_ < 0 ? errno : 0;
  }
  if (error_ == 0) {
    Entry* entry = Entry::first;
    while (entry != nullptr && entry->is_there) entry = entry->next;
    if (entry == nullptr) {
      if (Entry::first == nullptr) handle_ending_signals();
      entry = new Entry;
      entry->next = Entry::first;
      Entry::first = entry;
    }
    entry->path = path_;
    entry->is_folder = is_folder;
    entry->is_there = true;
    entry_ = entry;
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

TemporaryPath TemporaryPath::new_file(const std::string& pattern) { return {pattern, false}; }

TemporaryPath TemporaryPath::new_folder(const std::string& pattern) { return {pattern, true}; }

TemporaryPath::TemporaryPath(TemporaryPath&& other) noexcept
    : path_(std::move(other.path_)),
      error_(other.error_),
      descriptor_(other.descriptor_),
      entry_(std::exchange(other.entry_, nullptr)) {}

TemporaryPath::~TemporaryPath() {
  if (!entry_) return;
  entry_->is_folder ? remove_folder(path_.c_str()) : static_cast<void>(::unlink(path_.c_str()));
  keep();
}

void TemporaryPath::keep() {
  const std::lock_guard lock(changing_list);
  if (entry_) entry_->is_there = false;
  entry_ = nullptr;
}

TemporaryPath temporary_folder(const std::string& purpose, const std::string& what) {
  std::error_code none;
  const auto place = std::filesystem::temp_directory_path(none);
  TemporaryPath folder =
      TemporaryPath::new_folder((place / ("isolux-" + purpose + "-XXXXXX")).string());
  if (!none && folder.error() == 0) return folder;
  throw WorkError(what, "there is no temporary folder for it", "set TMPDIR to a folder with room");
}

void remove_temporary_paths() {
  const TemporaryPath::Entry* entry = TemporaryPath::Entry::first;
  for (; entry != nullptr; entry = entry->next) {
    if (!entry->is_there) continue;
    entry->is_folder ? remove_folder(entry->path.c_str())
                     : static_cast<void>(::unlink(entry->path.c_str()));
  }
}

}  // namespace isolux
