#pragma once

#include <map>
#include <string>
#include <vector>

#include "isolux/scene/option_table.h"

namespace isolux {

/// What was written behind a command's name.
struct Arguments {
  std::vector<std::string> inputs;
  std::map<std::string, std::vector<std::string>> values;  ///< by option name, in order

  bool has(const std::string& name) const { return values.contains(name); }
  /// The option's only value; it must be there.
  const std::string& at(const std::string& name) const { return values.at(name).front(); }
};

struct Example {
  std::string command;
  std::string sentence;
};

/// One command of the program. The list of them feeds parsing, --help and the manual page.
struct Command {
  std::string name;
  std::string inputs;  ///< how inputs are shown: "[INPUT...]", "[INPUT]" or nothing
  std::string sentence;
  std::vector<Option> options;  ///< beside the scene's
  bool takes_scene = false;     ///< whether all scene options go with it
  std::vector<Example> examples;
  int (*run)(const Command&, const Arguments&);
};

const std::vector<Command>& commands();

/// All options of a command: its own, then the scene's.
std::vector<Option> all_options(const Command& command);

/// Sorts the arguments behind a command's name.
/// @throws UsageError  on unknown options, missing values, or options given twice.
Arguments parse(const Command& command, const std::vector<std::string>& arguments);

/// Makes --max-memory and --trust hold for the whole process, where they are given.
void apply_policies(const Arguments& arguments);

/// How many threads the command may use; 0: all.
int thread_count(const Arguments& arguments);

int run_render(const Command&, const Arguments&);
int run_explain(const Command&, const Arguments&);
int run_info(const Command&, const Arguments&);
int run_convert(const Command&, const Arguments&);
int run_mesh(const Command&, const Arguments&);
int run_view(const Command&, const Arguments&);
int run_bench(const Command&, const Arguments&);
int run_manual(const Command&, const Arguments&);

}  // namespace isolux
