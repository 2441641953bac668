#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>

namespace isolux {

/// A fence for libraries that a hostile file can bring down: the work is done in a forked child
/// process, which can crash, hang or hoard without harm, and sends its results home in order.

struct FenceLimits {
  double seconds = 10;    ///< the longest wait for the next bytes
  double memory = 512e6;  ///< bytes the child may add to what this process has already
};

/// Leaves memory that is about to be filled out of children that are made from now on: it would be
/// copied, page by page, as it is filled beside them. Does nothing for less than 33 MiB.
void keep_from_fences(void* memory, std::size_t bytes);

/// The child did not send what was asked for. what() says why, to go on after "reading it ...".
class FenceBroken : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The child's end.
class FenceOutput {
 public:
  explicit FenceOutput(int file) : file_(file) {}
  void send(const void* bytes, std::size_t count);
  void send_text(const std::string& text);
  void send_error(const std::string& what);

 private:
  void send_raw(const void* bytes, std::size_t count);

  int file_;
};

/// A child at work, and this process's end of it. The child is a copy of this process with one
/// thread: `work` must not use parallel_for. It hears and says nothing (standard input, output and
/// error are closed), and has no file open but what it opens itself. It is gone when this is.
/// Several threads may have one each.
class Fence {
 public:
  /// @throws WorkError  where no child can be started.
  Fence(const FenceLimits& limits, const std::function<void(FenceOutput&)>& work);
  ~Fence();
  Fence(const Fence&) = delete;
  Fence& operator=(const Fence&) = delete;

  /// The next bytes that were sent.
  /// @throws FenceBroken; and the WorkError that ended the child's work, where one did.
  void receive(void* bytes, std::size_t count);
  std::string receive_text();

 private:
  void receive_raw(void* bytes, std::size_t count);

  double seconds_;
  int child_ = -1;
  int file_ = -1;
  std::uint64_t left_ = 0;  // of what was sent at a stroke
};

}  // namespace isolux
