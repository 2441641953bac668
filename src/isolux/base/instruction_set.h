#pragma once

#include <string>
#include <vector>

namespace isolux {

/// The instruction sets that code in lanes is compiled for, by name, from the least to the best:
/// "scalar" (the plain code, no lanes), "sse4", "avx2", "avx512".
const std::vector<std::string>& instruction_sets();

/// Holds all code in lanes to an instruction set of that list; without this it uses the best that
/// the machine has. From avx2 up the results are the same to the bit.
/// @throws WorkError  where the machine lacks it.
void hold_to_instruction_set(const std::string& name);

/// The one in use now.
std::string instruction_set_in_use();

}  // namespace isolux
