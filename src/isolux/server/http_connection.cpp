#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/temporary_path.h"
#include "isolux/server/connection.h"
#include "isolux/server/messages.h"
#include "isolux/server/page_files.h"
#include "isolux/server/target.h"

namespace isolux {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace fs = std::filesystem;
namespace http = beast::http;

constexpr auto kPatience = std::chrono::seconds(30);
constexpr auto kPatienceWithData = std::chrono::hours(1);  // for those who have the token
constexpr std::size_t kLongestHeader = 16 << 10;
constexpr std::size_t kLongestWorkName = 64;
constexpr const char* kWorkName = "X-Isolux-Work";  // what a page calls its long work

// No script, style, font or connection but our own; nothing may frame the page; nobody is told
// where a link was followed from.
constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "font-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

struct Reply {
  http::status status = http::status::ok;
  std::string content_type = "text/plain; charset=utf-8";
  std::string body;
};

// What went wrong, as a reply: the fault of the request, or of the work.
Reply reply_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const UsageError& error) {
    return {http::status::bad_request, "text/plain; charset=utf-8", error.what()};
  } catch (const std::bad_alloc&) {
    return {http::status::unprocessable_entity, "text/plain; charset=utf-8",
            "memory: there is not enough; try a smaller picture or volume"};
  } catch (const std::exception& error) {
    return {http::status::unprocessable_entity, "text/plain; charset=utf-8", error.what()};
  }
}

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(Place& place, asio::ip::tcp::socket socket)
      : place_(place), stream_(std::move(socket)) {
    ++place_.connections;
  }
  ~HttpConnection() { --place_.connections; }

  void read_header() {
    header_.emplace();
    header_->header_limit(kLongestHeader);
    // Set once it is known what comes. (boost::none would be taken for 0 by Beast of Boost 1.74.)
    header_->body_limit(std::numeric_limits<std::uint64_t>::max());
    stream_.expires_after(kPatience);
    const auto silent = place_.silent.insert(place_.silent.end(), [this] { stream_.close(); });
    http::async_read_header(
        stream_, buffer_, *header_,
        [self = shared_from_this(), silent](const beast::error_code& error, std::size_t) {
          self->place_.silent.erase(silent);
          if (!error) self->answer();
        });
  }

 private:
  void answer() {
    const auto& request = header_->get();
    keep_alive_ = request.keep_alive();
    is_head_ = request.method() == http::verb::head;
    work_name_ = text_of(request[kWorkName]).substr(0, kLongestWorkName);
    const std::string host = text_of(request[http::field::host]);
    if (!place_.access.host_is_ours(host)) {
      return refuse(http::status::misdirected_request, "this name is not one of isolux's own");
    }
    const Target target = parse_target(text_of(request.target()));
    if (beast::websocket::is_upgrade(request)) return upgrade(target, host);
    if (request.method() == http::verb::get || is_head_) return send_page(target);
    if (request.method() != http::verb::post) {
      return refuse(http::status::method_not_allowed, "only GET, HEAD and POST are known");
    }
    const std::string bearer = text_of(request[http::field::authorization]);
    const bool has_token =
        bearer.starts_with("Bearer ") && place_.access.token_is_right(bearer.substr(7));
    if (!has_token || !place_.access.origin_is_ours(text_of(request[http::field::origin]), host)) {
      return refuse(http::status::forbidden, "open the whole URL that isolux view printed");
    }
    if (target.path == "/progress") return tell_progress();
    if (target.path == "/save") return save();
    if (target.path == "/open") return open(target);
    refuse(http::status::not_found, "there is no such place");
  }

  static std::string text_of(beast::string_view text) { return {text.data(), text.size()}; }

  // A browser cannot set headers on a WebSocket, but offer names of protocols: the second one is
  // the token.
  void upgrade(const Target& target, const std::string& host) {
    const auto& request = header_->get();
    const std::string offered = text_of(request[http::field::sec_websocket_protocol]);
    const std::string prefix = "isolux.1, ";
    const bool has_token =
        offered.starts_with(prefix) && place_.access.token_is_right(offered.substr(prefix.size()));
    if (target.path != "/socket" || !has_token ||
        !place_.access.origin_is_ours(text_of(request[http::field::origin]), host)) {
      return refuse(http::status::forbidden, "open the whole URL that isolux view printed");
    }
    serve_web_socket(place_, std::move(stream_), header_->release());
  }

  void send_page(const Target& target) {
    const PageFile* file = find_page_file(target.path);
    if (!file) return refuse(http::status::not_found, "there is no such page");
    auto response = new_response(http::status::ok, std::string(file->content_type));
    response->set(http::field::content_encoding, "gzip");
    response->set(http::field::cache_control,
                  target.path.starts_with("/assets/") ? "max-age=31536000, immutable" : "no-cache");
    response->content_length(file->gzip.size());
    if (!is_head_) response->body() = file->gzip;
    send(std::move(response));
  }

  void save() {
    auto parser = std::make_shared<http::request_parser<http::string_body>>(std::move(*header_));
    parser->body_limit(kLongestMessage);
    http::async_read(
        stream_, buffer_, *parser,
        [self = shared_from_this(), parser](const beast::error_code& error, std::size_t) {
          if (error) return;
          self->work_long([self, parser](const ProgressListener& listener) {
            const nlohmann::json request = parse_json(parser->get().body());
            std::string picture = self->place_.viewer.saved_picture(request, listener);
            return Reply{http::status::ok, request["format"] == "exr" ? "image/x-exr" : "image/png",
                         std::move(picture)};
          });
        });
  }

  void open(const Target& target) {
    const auto length = header_->content_length();
    const std::string name = bare_file_name(target.name);
    if (!length) return refuse(http::status::length_required, "say how long the file is");
    auto parser = std::make_shared<http::request_parser<http::file_body>>(std::move(*header_));
    const bool is_packed = header_->get()[http::field::content_type] == "application/x-tar";
    std::shared_ptr<TemporaryPath> folder;
    DroppedFile file{{}, name, is_packed};
    try {
      check_memory(static_cast<double>(*length), name);
      folder = std::make_shared<TemporaryPath>(temporary_folder("dropped", name));
      file.path = (fs::path(folder->path()) / name).string();
      beast::error_code error;
      parser->get().body().open(file.path.c_str(), beast::file_mode::write_new, error);
      if (error) throw WorkError(name, "cannot be kept: " + error.message(), "rename the file");
    } catch (...) {
      const Reply reply = reply_of(std::current_exception());
      return refuse(reply.status, reply.body);
    }
    parser->body_limit(*length);
    stream_.expires_after(kPatienceWithData);
    http::async_read(stream_, buffer_, *parser,
                     [self = shared_from_this(), parser, folder, file](
                         const beast::error_code& error, std::size_t) {
                       parser->get().body().close();
                       if (error) return;
                       self->work_long([self, folder, file](const ProgressListener& listener) {
                         return Reply{http::status::ok, "application/json",
                                      self->place_.viewer.open_dropped(file, listener)};
                       });
                     });
  }

  // How far the work is that the page calls so; null where there is none (any more).
  void tell_progress() {
    const auto report = place_.viewer.long_work().report(work_name_);
    auto response = new_response(http::status::ok, "application/json");
    response->body() = report ? report->dump() : "null";
    response->prepare_payload();
    send(std::move(response));
  }

  // Does `work` on the viewer's thread for that, and sends what it gives; ends it early when the
  // page goes away.
  void work_long(std::function<Reply(const ProgressListener&)> work) {
    stream_.expires_never();
    const auto errand = place_.viewer.long_work().add(
        work_name_, [self = shared_from_this(), work = std::move(work)](Errand& own) {
          Reply reply;
          try {
            reply = work(own.listener());
          } catch (...) {
            reply = reply_of(std::current_exception());
          }
          asio::post(self->place_.loop, [self, done = std::move(reply)]() mutable {
            self->stream_.socket().cancel();  // no need to watch it any more
            auto response = self->new_response(done.status, done.content_type);
            response->body() = std::move(done.body);
            response->prepare_payload();
            self->stream_.expires_after(kPatienceWithData);
            self->send(std::move(response));
          });
        });
    if (!errand) {
      return refuse(http::status::service_unavailable, "too much is being done; try again soon");
    }
    // A page says nothing more before it has its reply, so what can be read is its going away.
    stream_.socket().async_wait(
        asio::ip::tcp::socket::wait_read,
        [self = shared_from_this(), errand](const beast::error_code& error) {
          if (!error) errand->cancel();
        });
  }

  using Response = http::response<http::string_body>;

  std::shared_ptr<Response> new_response(http::status status, const std::string& content_type) {
    auto response = std::make_shared<Response>(status, 11);
    response->set(http::field::content_type, content_type);
    response->set("Content-Security-Policy", kContentPolicy);
    response->set("Referrer-Policy", "no-referrer");
    response->set("X-Content-Type-Options", "nosniff");
    response->set("Cross-Origin-Opener-Policy", "same-origin");
    response->set("Cross-Origin-Resource-Policy", "same-origin");
    response->set(http::field::cache_control, "no-store");
    return response;
  }

  // Whatever else the request holds is not read, so the connection ends with the reply.
  void refuse(http::status status, const std::string& why) {
    keep_alive_ = false;
    auto response = new_response(status, "text/plain; charset=utf-8");
    response->body() = why + "\n";
    response->prepare_payload();
    if (is_head_) response->body().clear();
    send(std::move(response));
  }

  void send(std::shared_ptr<Response> response) {
    response->keep_alive(keep_alive_);
    http::async_write(
        stream_, *response,
        [self = shared_from_this(), response](const beast::error_code& error, std::size_t) {
          if (error) return;
          if (self->keep_alive_) return self->read_header();
          beast::error_code ignored;
          self->stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
        });
  }

  Place& place_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{kLongestHeader + (64 << 10)};
  std::optional<http::request_parser<http::empty_body>> header_;
  bool keep_alive_ = false;
  bool is_head_ = false;
  std::string work_name_;
};

}  // namespace

void serve_http(Place& place, asio::ip::tcp::socket socket) {
  std::make_shared<HttpConnection>(place, std::move(socket))->read_header();
}

}  // namespace isolux
