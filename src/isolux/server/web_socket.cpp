#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>

#include "isolux/server/connection.h"
#include "isolux/server/messages.h"

namespace isolux {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Clock = std::chrono::steady_clock;

constexpr double kMessagesASecond = 600, kMessagesAtOnce = 1200;
constexpr std::size_t kMostUnsent = 128;
constexpr std::size_t kMostUnsentBytes = 16 << 20;  // one more message may come

// Counts messages against a rate, with some slack for bursts.
class RateLimit {
 public:
  bool allows_one_more() {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    left_ = std::min(kMessagesAtOnce, left_ + kMessagesASecond * seconds);
    if (left_ < 1) return false;
    --left_;
    return true;
  }

 private:
  double left_ = kMessagesAtOnce;
  Clock::time_point last_ = Clock::now();
};

// A page's connection. It lives while a read or a write is under way.
class Page final : public Outlet, public std::enable_shared_from_this<Page> {
 public:
  Page(Place& place, beast::tcp_stream stream) : place_(place), socket_(std::move(stream)) {
    ++place_.connections;
  }
  ~Page() override { --place_.connections; }

  void begin(const http::request<http::empty_body>& request) {
    beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has its own timeouts
    websocket::stream_base::timeout timeout{std::chrono::seconds(10), std::chrono::seconds(40),
                                            /*keep_alive_pings=*/true};
    socket_.set_option(timeout);
    socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(http::field::sec_websocket_protocol, "isolux.1");
    }));
    socket_.read_message_max(kLongestMessage);
    socket_.auto_fragment(false);  // a picture in one piece, not in hundreds
    socket_.async_accept(request, [self = shared_from_this()](const beast::error_code& error) {
      if (error) return;
      self->client_ = self->place_.viewer.connect(self);
      self->read();
    });
  }

  void send_text(std::string text) override { post(std::move(text), true); }
  void send_bytes(std::string bytes) override { post(std::move(bytes), false); }

 private:
  struct Message {
    std::string bytes;
    bool is_text;
  };

  void post(std::string bytes, bool is_text) {
    asio::post(place_.loop,
               [self = shared_from_this(), message = Message{std::move(bytes), is_text}]() mutable {
                 if (self->left_) return;
                 if (self->unsent_.size() == kMostUnsent || self->unsent_bytes_ > kMostUnsentBytes)
                   return self->leave();  // it asks and does not read
                 self->unsent_bytes_ += message.bytes.size();
                 self->unsent_.push_back(std::move(message));
                 if (self->unsent_.size() == 1) self->write();
               });
  }

  void write() {
    socket_.text(unsent_.front().is_text);
    socket_.async_write(asio::buffer(unsent_.front().bytes),
                        [self = shared_from_this()](const beast::error_code& error, std::size_t) {
                          if (error) return self->leave();
                          self->unsent_bytes_ -= self->unsent_.front().bytes.size();
                          self->unsent_.pop_front();
                          if (!self->unsent_.empty()) self->write();
                        });
  }

  void read() {
    socket_.async_read(
        buffer_, [self = shared_from_this()](const beast::error_code& error, std::size_t) {
          if (self->left_) return;  // since this message came, its answers could not be sent
          if (error || !self->rate_.allows_one_more()) return self->leave();
          const auto data = self->buffer_.cdata();
          self->client_->receive({static_cast<const char*>(data.data()), data.size()});
          self->buffer_.clear();
          self->read();
        });
  }

  void leave() {
    if (left_) return;
    left_ = true;
    if (client_) client_->leave();
    client_.reset();
    beast::get_lowest_layer(socket_).close();
  }

  Place& place_;
  websocket::stream<beast::tcp_stream> socket_;
  std::shared_ptr<Client> client_;
  beast::flat_buffer buffer_;
  std::deque<Message> unsent_;
  std::size_t unsent_bytes_ = 0;
  RateLimit rate_;
  bool left_ = false;
};

}  // namespace

void serve_web_socket(Place& place, beast::tcp_stream stream,
                      const http::request<http::empty_body>& request) {
  std::make_shared<Page>(place, std::move(stream))->begin(request);
}

}  // namespace isolux
