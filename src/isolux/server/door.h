#pragma once

#include <memory>
#include <optional>
#include <string>

#include "isolux/server/viewer.h"

namespace isolux {

struct DoorOptions {
  std::string host = "127.0.0.1";  ///< what to listen on
  std::optional<int> port = {};    ///< nothing: kUsualPort, or a free one where that is taken
  std::string token;
};

inline constexpr int kUsualPort = 7411;

/// The HTTP and WebSocket server in front of a Viewer. It serves the page's own files to whoever
/// reaches it under its own name, and everything else only with the token (access.h).
class Door {
 public:
  /// Listens from here on. `viewer` outlives it.
  /// @throws WorkError  where it cannot.
  Door(const DoorOptions& options, Viewer& viewer);
  ~Door();

  int port() const;

  /// Serves until the program is interrupted (SIGINT, SIGTERM) or `stop` is called.
  void run();
  /// From any thread.
  void stop();

 private:
  struct Listening;
  std::unique_ptr<Listening> listening_;
};

}  // namespace isolux
