#include "isolux/io/read_fenced.h"

#include <memory>

#include "isolux/base/error.h"

namespace isolux {

ReadNext read_fenced(const std::string& path, double memory,
                     const std::function<void(FenceOutput&)>& work) {
  constexpr double kForTheLibrary = 256e6;
  const auto fence =
      std::make_shared<Fence>(FenceLimits{.seconds = 60, .memory = kForTheLibrary + memory}, work);
  return [fence, path](char* to, std::size_t count) {
    try {
      fence->receive(to, count);
    } catch (const FenceBroken& broken) {
      throw WorkError(path, std::string("is damaged: reading it ") + broken.what(),
                      "is the file complete?");
    }
  };
}

}  // namespace isolux
