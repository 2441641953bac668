#pragma once

#include <filesystem>

namespace isolux {

/// Where programs keep what should survive a restart: $XDG_STATE_HOME/isolux, or
/// ~/.local/state/isolux. Empty where there is no home. It may not exist yet.
std::filesystem::path user_state_folder();

}  // namespace isolux
