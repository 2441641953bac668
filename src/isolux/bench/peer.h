#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace isolux {

/// Another program that draws the same, in a process of its own. bench/README.md describes the
/// lines that are exchanged.
class Peer {
 public:
  /// Starts `command` (a path and its arguments) and waits until it says "ready NAME"; until then
  /// `name` is what it is called. Its standard error goes to the file `log`.
  /// @throws WorkError  where it does not get so far; says why in the words of the log's last line.
  Peer(const std::string& name, const std::vector<std::string>& command, const std::string& log);
  ~Peer();
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  const std::string& name() const { return name_; }

  /// Sends a line; the numbers of the answer.
  /// @throws WorkError  where the peer answers with an error, with fewer than `least` numbers, or
  /// not at all.
  std::vector<double> ask(const std::string& request, std::size_t least = 0);
  /// The first of them.
  double ask_ms(const std::string& request) { return ask(request, 1)[0]; }

 private:
  std::string receive_line();
  [[noreturn]] void fail(const std::string& why) const;

  std::string name_;
  std::string log_;
  pid_t process_ = -1;
  int socket_ = -1;
  std::string received_;  ///< behind the last line
};

}  // namespace isolux
