#include "isolux/server/long_work.h"

#include <algorithm>
#include <utility>

#include "isolux/base/error.h"

namespace isolux {
namespace {

constexpr std::size_t kMostErrands = 8;

}  // namespace

ProgressListener Errand::listener() {
  return [this](const std::string& label, double share) {
    if (is_cancelled_) throw WorkError(name_, "was cancelled", "begin again");
    const std::lock_guard lock(mutex_);
    label_ = label;
    share_ = share;
  };
}

nlohmann::json Errand::report() const {
  const std::lock_guard lock(mutex_);
  return {{"label", label_}, {"share", share_}};
}

std::shared_ptr<Errand> LongWork::add(const std::string& name, std::function<void(Errand&)> work) {
  const auto errand = std::make_shared<Errand>(name);
  {
    const std::lock_guard lock(mutex_);
    if (errands_.size() == kMostErrands) return nullptr;
    errands_.push_back(errand);
  }
  queue_.add([this, errand, work = std::move(work)] {
    work(*errand);
    const std::lock_guard lock(mutex_);
    std::erase(errands_, errand);
  });
  return errand;
}

std::optional<nlohmann::json> LongWork::report(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::ranges::find_if(errands_, [&](const auto& errand) { return errand->name() == name; });
  if (found == errands_.end()) return std::nullopt;
  return (*found)->report();
}

void LongWork::finish() {
  {
    const std::lock_guard lock(mutex_);
    for (const auto& errand : errands_) errand->cancel();
  }
  queue_.finish();
}

}  // namespace isolux
