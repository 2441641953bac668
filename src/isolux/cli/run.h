#pragma once

#include <string>
#include <vector>

namespace isolux {

/// Runs the command that the arguments (without the program's name) say, and returns the exit
/// status: 0 done, 1 the work could not be done, 2 the command was wrong. On 1 and 2 the last line
/// on standard error is `isolux: error: WHAT: WHY; HINT`.
int run(const std::vector<std::string>& arguments);

}  // namespace isolux
