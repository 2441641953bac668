#include "isolux/base/progress.h"

#include <algorithm>
#include <utility>

namespace isolux {

Progress::Progress(const ProgressListener& listener, std::string label, std::size_t steps)
    : listener_(listener), label_(std::move(label)), steps_(std::max<std::size_t>(steps, 1)) {
  if (listener_) listener_(label_, 0);
}

void Progress::advance(std::size_t steps) {
  if (!listener_) return;
  const std::size_t percent = 100 * std::min(done_ += steps, steps_) / steps_;
  const std::lock_guard lock(telling_);
  if (percent <= told_percent_) return;
  told_percent_ = percent;
  listener_(label_, static_cast<double>(percent) / 100);
}

}  // namespace isolux
