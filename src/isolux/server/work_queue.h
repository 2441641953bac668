#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace isolux {

/// Does pieces of work in the order in which they came, on threads of its own. Who adds its next
/// piece only when the last is done takes turns with all others.
class WorkQueue {
 public:
  explicit WorkQueue(int threads);
  ~WorkQueue() { finish(); }

  /// `work` must not throw.
  void add(std::function<void()> work);

  std::size_t waiting() const;

  /// Forgets what has not begun, waits for what has, and takes nothing more.
  void finish();

 private:
  void work_on();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace isolux
