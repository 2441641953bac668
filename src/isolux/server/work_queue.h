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
  /// @param at_once  how many pieces are done beside each other.
  /// @param aside  how many more may be under way, having stepped aside.
  explicit WorkQueue(int at_once, int aside = 0);
  ~WorkQueue() { finish(); }

  /// `work` must not throw.
  void add(std::function<void()> work);

  /// Held by a piece of work, so that others need not wait for its end where it turns out to be
  /// long.
  class Place {
   public:
    explicit Place(WorkQueue& queue) : queue_(queue) {}
    ~Place();
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    /// From here on another piece is done in its place; any thread of the work may say so, also
    /// more than once.
    void step_aside();

   private:
    WorkQueue& queue_;
    bool is_aside_ = false;
  };

  std::size_t waiting() const;

  /// Forgets what has not begun, waits for what has, and takes nothing more.
  void finish();

 private:
  void work_on();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  int at_once_;
  int under_way_ = 0;  ///< without those that have stepped aside
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace isolux
