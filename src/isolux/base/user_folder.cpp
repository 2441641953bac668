#include "isolux/base/user_folder.h"

#include <cstdlib>

namespace isolux {

std::filesystem::path user_state_folder() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::filesystem::path(value ? value : "");
  };
  if (!variable("XDG_STATE_HOME").empty()) return variable("XDG_STATE_HOME") / "isolux";
  if (!variable("HOME").empty()) return variable("HOME") / ".local/state/isolux";
  return {};
}

}  // namespace isolux
