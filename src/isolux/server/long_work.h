#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "isolux/base/progress.h"
#include "isolux/server/work_queue.h"

namespace isolux {

/// A piece of long work: how far it is, and whether anyone still waits for it. Any thread may call.
class Errand {
 public:
  explicit Errand(std::string name) : name_(std::move(name)) {}

  const std::string& name() const { return name_; }
  /// Keeps what it is told, for `report`, and throws a WorkError once nobody waits any more. The
  /// errand outlives it.
  ProgressListener listener();
  void cancel() { is_cancelled_ = true; }
  /// { "label", "share" }
  nlohmann::json report() const;

 private:
  std::string name_;  // as the page calls it
  std::atomic<bool> is_cancelled_ = false;
  mutable std::mutex mutex_;
  std::string label_ = "waiting";
  double share_ = 0;
};

/// Work that takes its time, such as reading a file: one piece after another, at most eight. Any
/// thread may call.
class LongWork {
 public:
  /// `work` must not throw.
  /// @return nothing, and nothing will be done, where too much is waiting.
  std::shared_ptr<Errand> add(const std::string& name, std::function<void(Errand&)> work);

  /// Of the piece of that name; nothing where there is none (any more).
  std::optional<nlohmann::json> report(const std::string& name) const;

  /// Ends what is under way, and takes nothing more.
  void finish();

 private:
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<Errand>> errands_;
  WorkQueue queue_{1};
};

}  // namespace isolux
