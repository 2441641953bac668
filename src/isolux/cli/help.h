#pragma once

#include <string>

#include "isolux/cli/command.h"

namespace isolux {

/// What `isolux --help` prints.
std::string program_help();
/// What `isolux COMMAND --help` prints.
std::string command_help(const Command& command);
/// The manual page: every command and option, in Markdown.
std::string manual();

}  // namespace isolux
