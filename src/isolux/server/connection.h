#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <functional>
#include <list>
#include <memory>

#include "isolux/server/access.h"
#include "isolux/server/viewer.h"

// What door.cpp, http_connection.cpp and web_socket.cpp share. Everything runs on the one thread of
// Door::run, but for what is said to be posted there.

namespace isolux {

struct Place {
  boost::asio::io_context& loop;
  const Access& access;
  Viewer& viewer;
  std::atomic<int> connections = 0;  ///< that are open now
  /// How to close those that are waited for to say something, the longest waiting first.
  std::list<std::function<void()>> silent = {};
};

inline constexpr int kMostConnections = 128;

/// Serves HTTP on an accepted connection until it closes or becomes a WebSocket.
void serve_http(Place& place, boost::asio::ip::tcp::socket socket);

/// Goes on with a connection whose checked request wants a WebSocket.
void serve_web_socket(Place& place, boost::beast::tcp_stream stream,
                      const boost::beast::http::request<boost::beast::http::empty_body>& request);

}  // namespace isolux
