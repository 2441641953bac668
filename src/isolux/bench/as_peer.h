#pragma once

#include <string>

namespace isolux {

/// isolux as a peer of itself: answers the requests of bench/README.md on standard input until it
/// ends. So one build can be measured against another, or one instruction set against another, with
/// their frames interleaved. `name` is what it calls itself.
void answer_as_peer(const std::string& name);

}  // namespace isolux
