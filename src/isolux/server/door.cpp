#include "isolux/server/door.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>

#include "isolux/base/error.h"
#include "isolux/server/connection.h"

namespace isolux {

namespace asio = boost::asio;
using asio::ip::tcp;

namespace {

boost::system::error_code listen_on(tcp::acceptor& acceptor, const tcp::endpoint& endpoint) {
  boost::system::error_code error;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    boost::system::error_code ignored;
    acceptor.close(ignored);
  }
  return error;
}

}  // namespace

struct Door::Listening {
  Listening(const DoorOptions& options, Viewer& viewer)
      : access(options.token, options.host), place{loop, access, viewer} {
    const std::string name = options.host == "localhost" ? "127.0.0.1" : options.host;
    boost::system::error_code error;
    const asio::ip::address address = asio::ip::make_address(name, error);
    if (error) {
      throw UsageError("--host", "'" + options.host + "' is no numeric address",
                       "give 127.0.0.1, or 0.0.0.0 for all of this machine's addresses");
    }
    const int wanted = options.port.value_or(kUsualPort);
    error = listen_on(acceptor, {address, static_cast<unsigned short>(wanted)});
    if (error && !options.port) error = listen_on(acceptor, {address, 0});
    if (error) {
      throw WorkError(
          "view",
          "cannot listen on " + name + ":" + std::to_string(wanted) + ": " + error.message(),
          "give another --port");
    }
    signals.async_wait([this](const auto& failure, int) {
      if (!failure) loop.stop();
    });
    accept();
  }

  void accept() {
    acceptor.async_accept([this](const auto& error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error && make_room()) serve_http(place, std::move(socket));
      accept();
    });
  }

  // Those who only hold the line make way.
  bool make_room() {
    if (place.connections < kMostConnections) return true;
    if (place.silent.empty()) return false;
    place.silent.front()();
    return true;
  }

  asio::io_context loop{1};
  Access access;
  Place place;
  tcp::acceptor acceptor{loop};
  asio::signal_set signals{loop, SIGINT, SIGTERM};
};

Door::Door(const DoorOptions& options, Viewer& viewer)
    : listening_(std::make_unique<Listening>(options, viewer)) {}

Door::~Door() = default;

int Door::port() const { return listening_->acceptor.local_endpoint().port(); }

void Door::run() { listening_->loop.run(); }

void Door::stop() { listening_->loop.stop(); }

}  // namespace isolux
