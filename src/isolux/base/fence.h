#pragma once

#include <cstddef>
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

 private:
  int file_;
};

/// This process's end. Both functions throw FenceBroken.
class FenceInput {
 public:
  FenceInput(int file, double seconds) : file_(file), seconds_(seconds) {}
  void receive(void* bytes, std::size_t count);
  std::string receive_text();

 private:
  int file_;
  double seconds_;
};

/// Runs `work` in a child and `use` here, at the same time. The child is a copy of this process
/// with one thread: `work` must not use parallel_for. It hears and says nothing (standard input,
/// output and error are closed), and it is gone when this returns or throws. May be called from
/// several threads.
/// @throws FenceBroken; WorkError where no child can be started; and whatever `use` throws.
void run_fenced(const FenceLimits& limits, const std::function<void(FenceOutput&)>& work,
                const std::function<void(FenceInput&)>& use);

}  // namespace isolux
