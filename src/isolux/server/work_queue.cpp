#include "isolux/server/work_queue.h"

#include <utility>

namespace isolux {

WorkQueue::WorkQueue(int at_once, int aside) : at_once_(at_once) {
  for (int n = 0; n < at_once + aside; ++n) threads_.emplace_back([this] { work_on(); });
}

void WorkQueue::finish() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    waiting_.clear();
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

void WorkQueue::add(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    if (ending_) return;
    waiting_.push_back(std::move(work));
  }
  changed_.notify_one();
}

std::size_t WorkQueue::waiting() const {
  const std::lock_guard lock(mutex_);
  return waiting_.size();
}

void WorkQueue::work_on() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ending_ || (!waiting_.empty() && under_way_ < at_once_); });
    if (ending_) return;
    ++under_way_;
    const std::function<void()> work = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    work();
    lock.lock();
    --under_way_;
    changed_.notify_one();
  }
}

void WorkQueue::Place::step_aside() {
  const std::lock_guard lock(queue_.mutex_);
  if (is_aside_) return;
  is_aside_ = true;
  --queue_.under_way_;
  queue_.changed_.notify_one();
}

WorkQueue::Place::~Place() {
  const std::lock_guard lock(queue_.mutex_);
  if (is_aside_) ++queue_.under_way_;
}

}  // namespace isolux
