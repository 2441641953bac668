#include "isolux/cli/run.h"

#include <algorithm>
#include <iostream>
#include <new>
#include <system_error>

#include "isolux/base/error.h"
#include "isolux/base/parallel.h"
#include "isolux/cli/command.h"
#include "isolux/cli/help.h"

namespace isolux {
namespace {

constexpr int kWorkFailed = 1;
constexpr int kUsageWrong = 2;

int report(const Error& error, int status) {
  std::cerr << "isolux: error: " << error.what() << std::endl;
  return status;
}

const Command& command_named(const std::string& name) {
  for (const Command& command : commands()) {
    if (command.name == name) return command;
  }
  std::string names;
  for (const Command& command : commands()) names += (names.empty() ? "" : ", ") + command.name;
  throw UsageError(name, "is no command", "the commands are " + names);
}

bool asks_for_help(const std::vector<std::string>& arguments) {
  return std::ranges::any_of(arguments, [](const auto& a) { return a == "--help" || a == "-h"; });
}

int run_unguarded(const std::vector<std::string>& arguments) {
  if (arguments.empty() || arguments[0] == "--help" || arguments[0] == "-h" ||
      arguments[0] == "help") {
    std::cout << program_help();
    return 0;
  }
  if (arguments[0] == "--version") {
    std::cout << "isolux " << ISOLUX_VERSION << "\n";
    return 0;
  }
  const Command& command = command_named(arguments[0]);
  const std::vector<std::string> rest(arguments.begin() + 1, arguments.end());
  if (asks_for_help(rest)) {
    std::cout << command_help(command);
    return 0;
  }
  const Arguments parsed = parse(command, rest);
  for (const Option& option : command.options) {
    if (parsed.has(option.name) && !option.not_yet.empty()) {
      throw UsageError("--" + option.name, option.not_yet, "leave it out");
    }
  }
  apply_policies(parsed);
  int status = 0;
  with_threads(thread_count(parsed), [&] { status = command.run(command, parsed); });
  return status;
}

}  // namespace

int run(const std::vector<std::string>& arguments) {
  try {
    const int status = run_unguarded(arguments);
    std::cout.flush();
    if (!std::cout) throw WorkError("standard output", "cannot be written", "is the disk full?");
    return status;
  } catch (const UsageError& error) {
    return report(error, kUsageWrong);
  } catch (const Error& error) {
    return report(error, kWorkFailed);
  } catch (const std::bad_alloc&) {
    return report(WorkError("memory", "there is not enough", "try a smaller picture or volume"),
                  kWorkFailed);
  } catch (const std::system_error& error) {
    return report(
        WorkError("isolux", error.what(), "the machine has run out of something it needs"),
        kWorkFailed);
  } catch (const std::exception& error) {
    return report(
        WorkError("isolux", error.what(), "this is a fault of the program; please report it"),
        kWorkFailed);
  }
}

}  // namespace isolux
