#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>

namespace isolux {

/// Receives how far a piece of work is: its label and a share in [0, 1]. Empty: nobody looks.
using ProgressListener = std::function<void(const std::string& label, double share)>;

/// Counts the steps of one piece of work and tells the listener at each percent, and where that
/// takes long, ten times a second, so that listeners who throw to cancel are heard. `advance` may
/// be called from many threads.
class Progress {
 public:
  Progress(const ProgressListener& listener, std::string label, std::size_t steps);
  void advance(std::size_t steps = 1);

 private:
  const ProgressListener& listener_;
  std::string label_;
  std::size_t steps_;
  std::atomic<std::size_t> done_{0};
  std::size_t told_percent_ = 0;
  std::chrono::steady_clock::time_point told_at_;
  std::mutex telling_;
};

}  // namespace isolux
