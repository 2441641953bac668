#include "isolux/base/progress.h"

#include <algorithm>
#include <utility>

namespace isolux {

constexpr auto kLongest = std::chrono::milliseconds(100);

Progress::Progress(const ProgressListener& listener, std::string label, std::size_t steps)
    : listener_(listener),
      label_(std::move(label)),
      steps_(std::max<std::size_t>(steps, 1)),
      told_at_(std::chrono::steady_clock::now()) {
  if (listener_) listener_(label_, 0);
}

void Progress::advance(std::size_t steps) {
  if (!listener_) return;
  const std::size_t percent = 100 * std::min(done_ += steps, steps_) / steps_;
  const std::lock_guard lock(telling_);
  const auto now = std::chrono::steady_clock::now();
  if (percent <= told_percent_ && now - told_at_ < kLongest) return;
  told_percent_ = std::max(percent, told_percent_);
  told_at_ = now;
  listener_(label_, static_cast<double>(told_percent_) / 100);
}

}  // namespace isolux
