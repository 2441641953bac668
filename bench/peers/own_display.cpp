#include "own_display.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace {

// Xvfb writes the number that it took to the file that it is told, here a pipe.
[[noreturn]] void become_server(int number_to) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);    // however this process ends
  ::dup2(STDERR_FILENO, STDOUT_FILENO);  // standard output is for answers
  const std::string file = std::to_string(number_to);
  ::execlp("Xvfb", "Xvfb", "-displayfd", file.c_str(), "-screen", "0", "64x64x24", "-nolisten",
           "tcp", nullptr);
  ::_exit(127);
}

std::string read_to_newline(int file) {
  std::string text;
  for (char c = 0; ::read(file, &c, 1) == 1 && c != '\n';) text += c;
  return text;
}

}  // namespace

OwnDisplay::OwnDisplay() {
  int ends[2];
  if (::pipe(ends) != 0) throw std::runtime_error("there is no pipe to Xvfb");
  server_ = ::fork();
  if (server_ == 0) {
    ::close(ends[0]);
    become_server(ends[1]);
  }
  ::close(ends[1]);
  const std::string number = read_to_newline(ends[0]);
  ::close(ends[0]);
  if (number.empty()) throw std::runtime_error("Xvfb does not start; install xvfb");
  ::setenv("DISPLAY", (":" + number).c_str(), 1);
}

OwnDisplay::~OwnDisplay() {
  if (server_ <= 0) return;
  ::kill(server_, SIGTERM);
  ::waitpid(server_, nullptr, 0);
}
