#include "isolux/cli/open_browser.h"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "isolux/base/user_folder.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

bool is_set(const char* variable) {
  const char* value = std::getenv(variable);
  return value && *value;
}

// The file, or an empty path.
fs::path written_redirect(const std::string& url) {
  const fs::path folder = user_state_folder();
  if (folder.empty()) return {};
  const fs::path path = folder / "view.html";
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  fs::remove(path, ignored);
  const std::string text =
      "<!doctype html><meta charset=utf-8><title>isolux</title>"
      "<meta http-equiv=refresh content=\"0;url=" +
      url + "\">\n";
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) return {};
  const bool written = ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  ::close(file);
  return written ? path : fs::path();
}

}  // namespace

void open_browser(const std::string& url) {
  if (!is_set("DISPLAY") && !is_set("WAYLAND_DISPLAY")) return;
  const fs::path redirect = written_redirect(url);
  if (redirect.empty()) return;
  std::string program = "xdg-open", file = redirect.string();
  char* arguments[] = {program.data(), file.data(), nullptr};
  posix_spawn_file_actions_t quiet;
  ::posix_spawn_file_actions_init(&quiet);
  for (const int output : {STDOUT_FILENO, STDERR_FILENO}) {
    ::posix_spawn_file_actions_addopen(&quiet, output, "/dev/null", O_WRONLY, 0);
  }
  pid_t child = 0;
  ::posix_spawnp(&child, program.c_str(), &quiet, nullptr, arguments, environ);
  ::posix_spawn_file_actions_destroy(&quiet);
}

}  // namespace isolux
