#include "isolux/bench/peer.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "isolux/base/error.h"

namespace isolux {
namespace {

constexpr int kPatienceMs = 300'000;  // VTK takes seconds to extract a large surface

std::string last_line_of(const std::string& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

// The child's standard input and output are one end of a socket: writing to one that has died is an
// error then, where a pipe would send a signal.
pid_t spawn_on_socket(const std::vector<std::string>& command, int socket, const std::string& log) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, socket, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, socket, STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0600);
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t process = -1;
  const int error =
      posix_spawn(&process, command[0].c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw WorkError(command[0], std::strerror(error), "build it; see bench/README.md");
  }
  return process;
}

}  // namespace

Peer::Peer(const std::string& name, const std::vector<std::string>& command, const std::string& log)
    : name_(name), log_(log) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw WorkError(name_, std::strerror(errno), "the machine has run out of files");
  }
  socket_ = ends[0];
  try {
    process_ = spawn_on_socket(command, ends[1], log);
  } catch (...) {
    ::close(ends[0]);
    ::close(ends[1]);
    throw;
  }
  ::close(ends[1]);
  std::string line;
  try {
    line = receive_line();
    if (!line.starts_with("ready ")) fail("it began with '" + line + "'");
  } catch (...) {
    ::close(socket_);
    ::waitpid(process_, nullptr, 0);
    throw;
  }
  name_ = line.substr(std::string("ready ").size());
}

Peer::~Peer() {
  ::close(socket_);  // the end of its input: it ends as well
  ::waitpid(process_, nullptr, 0);
}

void Peer::fail(const std::string& why) const {
  const std::string told = last_line_of(log_);
  throw WorkError(name_, told.empty() ? why : why + " (" + told + ")",
                  "see bench/README.md, or run it by hand");
}

std::string Peer::receive_line() {
  while (true) {
    if (const std::size_t end = received_.find('\n'); end != std::string::npos) {
      const std::string line = received_.substr(0, end);
      received_.erase(0, end + 1);
      return line;
    }
    pollfd waiting{socket_, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, kPatienceMs);
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) {
      ::kill(process_, SIGKILL);
      fail("it has not answered for minutes");
    }
    char bytes[4096];
    const ssize_t count = ::recv(socket_, bytes, sizeof bytes, 0);
    if (count <= 0) fail("it has ended");
    received_.append(bytes, static_cast<std::size_t>(count));
  }
}

std::vector<double> Peer::ask(const std::string& request, std::size_t least) {
  const std::string line = request + "\n";
  if (::send(socket_, line.data(), line.size(), MSG_NOSIGNAL) !=
      static_cast<ssize_t>(line.size())) {
    fail("it has ended");
  }
  const std::string answer = receive_line();
  std::istringstream words(answer);
  std::string first;
  words >> first;
  std::vector<double> numbers;
  for (double number = 0; words >> number;) numbers.push_back(number);
  if (first != "ok" || numbers.size() < least) {
    fail("it answered '" + answer + "' to '" + request + "'");
  }
  return numbers;
}

}  // namespace isolux
