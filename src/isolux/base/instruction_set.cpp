#include "isolux/base/instruction_set.h"

#include <hwy/targets.h>

#include <array>

#include "isolux/base/error.h"

namespace isolux {
namespace {

struct InstructionSet {
  const char* name;
  std::int64_t target;  // Highway's bit: the better, the lower
};

constexpr std::array kSets{InstructionSet{"scalar", HWY_SCALAR}, InstructionSet{"sse4", HWY_SSE4},
                           InstructionSet{"avx2", HWY_AVX2}, InstructionSet{"avx512", HWY_AVX3}};

}  // namespace

const std::vector<std::string>& instruction_sets() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const InstructionSet& set : kSets) all.emplace_back(set.name);
    return all;
  }();
  return names;
}

void hold_to_instruction_set(const std::string& name) {
  hwy::DisableTargets(0);
  const std::int64_t there = hwy::SupportedTargets() | HWY_SCALAR;
  for (const InstructionSet& set : kSets) {
    if (set.name != name) continue;
    if ((there & set.target) == 0) {
      throw WorkError("--isa " + name, "this machine does not have it",
                      "leave it out to use the best there is: " + instruction_set_in_use());
    }
    hwy::DisableTargets(set.target - 1);  // all that are better
  }
}

std::string instruction_set_in_use() {
  const std::int64_t there = hwy::SupportedTargets();
  for (auto set = kSets.rbegin(); set != kSets.rend(); ++set) {
    if (there & set->target) return set->name;
  }
  return kSets.front().name;
}

}  // namespace isolux
