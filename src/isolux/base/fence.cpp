#include "isolux/base/fence.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <mutex>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"

namespace isolux {
namespace {

constexpr std::uint64_t kLongestText = 64 << 20;
// What is sent at a stroke has its length before it; that of an error has this bit.
constexpr std::uint64_t kErrorBit = std::uint64_t{1} << 63;

void limit(int resource, double most) {
  const rlimit both{static_cast<rlim_t>(most), static_cast<rlim_t>(most)};
  ::setrlimit(static_cast<__rlimit_resource>(resource), &both);
}

// Address space in use, in bytes. (With a sanitizer that is terabytes; the limit adds to it.)
double address_space() {
  long pages = 0;
  if (FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%ld", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return static_cast<double>(pages) * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

[[noreturn]] void be_child(const FenceLimits& limits, int file,
                           const std::function<void(FenceOutput&)>& work) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::signal(SIGPIPE, SIG_DFL);
  for (const int signal :
       {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGALRM, SIGINT, SIGTERM, SIGHUP})
    ::signal(signal, SIG_DFL);
  // Whatever this process has open is nothing to the child, which has room for files of its own
  // then.
  if (file > 3) ::close_range(3, static_cast<unsigned>(file) - 1, 0);
  ::close_range(static_cast<unsigned>(file) + 1, ~0U, 0);
  const int nowhere = ::open("/dev/null", O_RDWR);
  for (const int standard : {0, 1, 2}) ::dup2(nowhere, standard);
  if (const double used = address_space(); used > 0) limit(RLIMIT_AS, used + limits.memory);
  limit(RLIMIT_CORE, 0);
  FenceOutput output(file);
  try {
    work(output);
  } catch (const WorkError& error) {
    output.send_error(error.what());
    ::_exit(1);
  } catch (...) {
    ::_exit(1);
  }
  ::_exit(0);
}

WorkError no_child() {
  return {"decoder", std::string("no process for it can be started: ") + std::strerror(errno),
          "close other programs, or raise the limits"};
}

}  // namespace

void keep_from_fences(void* memory, std::size_t bytes) {
  // From here on the C library gives each block pages of its own (DEFAULT_MMAP_THRESHOLD_MAX is 32
  // MiB), so nothing else lies in them, now or later.
  constexpr std::size_t kOwnPages = 33 << 20;
  if (bytes < kOwnPages) return;
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(memory), end = begin + bytes;
  const std::uintptr_t first = (begin + page - 1) / page * page, last = end / page * page;
  ::madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTFORK);
}

void FenceOutput::send_raw(const void* bytes, std::size_t count) {
  const char* at = static_cast<const char*>(bytes);
  while (count > 0) {
    const ssize_t sent = ::write(file_, at, count);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) ::_exit(1);
    at += sent;
    count -= static_cast<std::size_t>(sent);
  }
}

void FenceOutput::send(const void* bytes, std::size_t count) {
  const std::uint64_t length = count;
  send_raw(&length, sizeof length);
  send_raw(bytes, count);
}

void FenceOutput::send_error(const std::string& what) {
  const std::uint64_t length = what.size() | kErrorBit;
  send_raw(&length, sizeof length);
  send_raw(what.data(), what.size());
}

void FenceOutput::send_text(const std::string& text) {
  const std::uint64_t length = text.size();
  send(&length, sizeof length);
  send(text.data(), text.size());
}

Fence::Fence(const FenceLimits& limits, const std::function<void(FenceOutput&)>& work)
    : seconds_(limits.seconds) {
  // One fork at a time, and the writing end closed before the next: a sibling that held it would
  // keep the end of this child's output from being seen.
  static std::mutex forking;
  const std::lock_guard lock(forking);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw no_child();
  child_ = ::fork();
  if (child_ == 0) be_child(limits, ends[1], work);
  ::close(ends[1]);
  file_ = ends[0];
  if (child_ < 0) {
    ::close(file_);
    throw no_child();
  }
}

Fence::~Fence() {
  ::close(file_);
  ::kill(child_, SIGKILL);
  while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void Fence::receive_raw(void* bytes, std::size_t count) {
  char* at = static_cast<char*>(bytes);
  while (count > 0) {
    pollfd ready{file_, POLLIN, 0};
    const int events = ::poll(&ready, 1, static_cast<int>(std::fmin(seconds_ * 1000, 2e9)));
    if (events < 0 && errno == EINTR) continue;
    if (events == 0) throw FenceBroken("took longer than " + to_text(seconds_) + " s");
    const ssize_t got = ::read(file_, at, count);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw FenceBroken("brought the decoder down");
    at += got;
    count -= static_cast<std::size_t>(got);
  }
}

void Fence::receive(void* bytes, std::size_t count) {
  char* at = static_cast<char*>(bytes);
  while (count > 0) {
    if (left_ == 0) receive_raw(&left_, sizeof left_);
    if ((left_ & kErrorBit) != 0) {
      std::string told(std::min(left_ & ~kErrorBit, kLongestText), '\0');
      receive_raw(told.data(), told.size());
      throw WorkError(told);
    }
    const auto taken = static_cast<std::size_t>(std::min<std::uint64_t>(count, left_));
    receive_raw(at, taken);
    at += taken;
    count -= taken;
    left_ -= taken;
  }
}

std::string Fence::receive_text() {
  std::uint64_t length = 0;
  receive(&length, sizeof length);
  if (length > kLongestText) throw FenceBroken("brought too much to light");
  std::string text(length, '\0');
  receive(text.data(), text.size());
  return text;
}

}  // namespace isolux
