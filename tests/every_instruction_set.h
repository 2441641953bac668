#pragma once

#include <string>

#include "isolux/base/error.h"
#include "isolux/base/instruction_set.h"

namespace isolux {

/// Calls use(name) with the program held to each instruction set that the machine has, from the
/// least to the best, at which it stays.
template <typename Use>
void on_every_instruction_set(const Use& use) {
  for (const std::string& name : instruction_sets()) {
    try {
      hold_to_instruction_set(name);
    } catch (const WorkError&) {
      return;
    }
    use(name);
  }
}

}  // namespace isolux
