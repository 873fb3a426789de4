#include "app/page/http_server.h"

#include <fmt/format.h>

#include <utility>  // must be first: Beast 1.74 uses std::exchange without including it

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <optional>

#include "app/page/page_service.h"
#include "base/error.h"

namespace hystcan::app {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using beast::error_code;
using boost::asio::ip::tcp;

constexpr std::size_t most_connections = 32;
constexpr std::uint32_t longest_header = 8'192;
constexpr std::size_t longest_message = 16'384;
constexpr std::size_t most_waiting = 8'388'608;
constexpr std::size_t most_waiting_rows = 1'048'576;
constexpr int send_buffer = 262'144;
constexpr auto longest_request = std::chrono::seconds(10);
constexpr auto longest_write = std::chrono::seconds(5);
// After this time without data from a client, the server sends a ping, which the client must answer.
constexpr auto longest_silence = std::chrono::seconds(20);
constexpr auto pause_after_failed_accept = std::chrono::milliseconds(100);

/// Content security policy. The browser may run, show and request only files of this server, and no other
/// site may embed the page in a frame.
constexpr const char* content_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' blob: "
    "data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

/// Returns the server's own address of a connection. If the server listens at all IPv4 and IPv6 addresses, an
/// IPv4 address has the form ::ffff:192.0.2.1; this function converts it to 192.0.2.1.
boost::asio::ip::address local_address(const tcp::socket& socket) {
  error_code ignored;
  boost::asio::ip::address address = socket.local_endpoint(ignored).address();
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address;
  return boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6());
}

HttpRequest plain(const Request& request, const tcp::socket& socket) {
  const auto text = [&](http::field field) { return std::string(request[field]); };
  return {.method = std::string(request.method_string()),
          .target = std::string(request.target()),
          .host = text(http::field::host),
          .origin = text(http::field::origin),
          .accept = text(http::field::accept),
          .local_address = local_address(socket).to_string()};
}

Response wired(const HttpResponse& answer, unsigned version, bool keep_alive) {
  Response response(http::int_to_status(answer.status), version);
  response.set(http::field::content_type, answer.type);
  response.set(http::field::cache_control, "no-store");
  response.set("Content-Security-Policy", content_policy);
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  if (answer.status == 405) response.set(http::field::allow, "GET, HEAD");
  response.keep_alive(keep_alive);
  response.body() = answer.body;
  response.prepare_payload();
  return response;
}

/// The content of a WebSocket message to a client: text or binary rows.
struct Outgoing {
  bool is_text = true;
  std::string text{};
  RowHead head{};
  RowBlock rows{};

  std::size_t bytes() const { return text.size() + (rows ? sizeof head + rows->size() * sizeof(double) : 0); }
};

class WebSession final : public WebClient, public std::enable_shared_from_this<WebSession> {
 public:
  WebSession(tcp::socket socket, PageService& page, std::shared_ptr<std::size_t> place)
      : stream_(std::move(socket)), timer_(stream_.get_executor()), page_(page), place_(std::move(place)) {}

  void start(const Request& upgrade) {
    websocket::stream_base::timeout limits =
        websocket::stream_base::timeout::suggested(beast::role_type::server);
    limits.handshake_timeout = longest_request;
    limits.idle_timeout = longest_silence;
    limits.keep_alive_pings = true;
    stream_.set_option(limits);
    stream_.read_message_max(longest_message);
    stream_.auto_fragment(false);
    stream_.async_accept(upgrade, [self = shared_from_this()](const error_code& error) {
      if (error) return;
      self->is_open_ = true;
      self->page_.opened(*self);
      self->read();
    });
  }

  void send_text(std::string text) override { send({.text = std::move(text)}); }

  bool takes_rows() const override { return waiting_bytes_ <= most_waiting_rows; }

  bool send_rows(const RowHead& head, const RowBlock& rows) override {
    if (!takes_rows()) return false;
    send({.is_text = false, .head = head, .rows = rows});
    return true;
  }

  void cut_off() override {
    if (!is_open_ || std::exchange(is_ending_, true)) return;
    page_.count_cut_off();
    end();
  }

  void end() {
    timer_.cancel();
    error_code ignored;
    // Closing makes the pending read fail, which ends the session.
    beast::get_lowest_layer(stream_).close(ignored);
  }

 private:
  void read() {
    stream_.async_read(received_, [self = shared_from_this()](const error_code& error, std::size_t) {
      if (error == websocket::error::message_too_big) self->cut_off();
      if (error) return self->closed();
      if (!self->stream_.got_text()) {
        self->cut_off();
        return self->closed();
      }
      const std::string text = beast::buffers_to_string(self->received_.data());
      self->received_.consume(self->received_.size());
      self->page_.received(*self, text);
      self->read();
    });
  }

  void closed() {
    timer_.cancel();
    if (std::exchange(is_open_, false)) page_.closed(*this);
  }

  void send(Outgoing message) {
    if (!is_open_ || is_ending_) return;
    waiting_bytes_ += message.bytes();
    if (waiting_bytes_ > most_waiting) return cut_off();
    waiting_.push_back(std::move(message));
    if (waiting_.size() == 1) write();
  }

  void write() {
    const Outgoing& message = waiting_.front();
    timer_.expires_after(longest_write);
    timer_.async_wait([self = weak_from_this()](const error_code& cancelled) {
      if (const auto session = self.lock(); session && !cancelled) session->cut_off();
    });
    stream_.text(message.is_text);
    const auto written = [self = shared_from_this()](const error_code& error, std::size_t) {
      self->timer_.cancel();
      if (error) return self->end();
      self->waiting_bytes_ -= self->waiting_.front().bytes();
      self->waiting_.pop_front();
      if (!self->waiting_.empty()) self->write();
    };
    if (message.is_text) return stream_.async_write(boost::asio::buffer(message.text), written);
    stream_.async_write(std::array<boost::asio::const_buffer, 2>{boost::asio::buffer(message.head),
                                                                 boost::asio::buffer(*message.rows)},
                        written);
  }

  websocket::stream<tcp::socket> stream_;
  boost::asio::steady_timer timer_;
  PageService& page_;
  std::shared_ptr<std::size_t> place_;
  beast::flat_buffer received_;
  std::deque<Outgoing> waiting_;
  std::size_t waiting_bytes_ = 0;
  bool is_open_ = false;
  bool is_ending_ = false;
};

class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(tcp::socket socket, PageService& page, std::shared_ptr<std::size_t> place)
      : stream_(std::move(socket)), page_(page), place_(std::move(place)) {}

  void read() {
    parser_.emplace();
    parser_->header_limit(longest_header);
    parser_->body_limit(0);
    stream_.expires_after(longest_request);
    http::async_read(
        stream_, received_, *parser_,
        [self = shared_from_this()](const error_code& error, std::size_t) { self->on_request(error); });
  }

  void close() { stream_.close(); }

 private:
  void on_request(const error_code& error) {
    if (error == http::error::header_limit)
      return respond({.status = 431, .body = "header too long\n"}, false);
    if (error == http::error::body_limit)
      return respond({.status = 413, .body = "a request may not have a body\n"}, false);
    if (error && error.category() == http::make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message)
      return respond({.status = 400, .body = "not HTTP\n"}, false);
    if (error) return;
    const Request& request = parser_->get();
    const HttpRequest plain_request = plain(request, stream_.socket());
    if (!websocket::is_upgrade(request))
      return respond(page_.answer(plain_request), request.keep_alive(), request.method() == http::verb::head);
    const HttpResponse admitted = page_.admit(plain_request);
    if (admitted.status != 101) return respond(admitted, false);
    stream_.expires_never();
    const auto session = std::make_shared<WebSession>(stream_.release_socket(), page_, place_);
    session->start(request);
  }

  void respond(const HttpResponse& answer, bool keep_alive, bool head_only = false) {
    const unsigned version = parser_->is_header_done() ? parser_->get().version() : 11;
    response_ = wired(answer, version, keep_alive);
    if (head_only) response_.body().clear();
    stream_.expires_after(longest_request);
    const auto written = [self = shared_from_this(), keep_alive](const error_code& error, std::size_t) {
      if (error) return;
      if (keep_alive) return self->read();
      error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    };
    http::async_write(stream_, response_, written);
  }

  beast::tcp_stream stream_;
  PageService& page_;
  std::shared_ptr<std::size_t> place_;
  beast::flat_buffer received_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  Response response_;
};

}  // namespace

class HttpServer::Listener {
 public:
  Listener(boost::asio::io_context& context, const tcp::endpoint& endpoint, PageService& page)
      : acceptor_(context, endpoint), pause_(context), page_(page) {
    accept();
  }
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }
  std::size_t sessions_kept() const { return requests_.size(); }

 private:
  void accept() {
    acceptor_.async_accept([this](const error_code& error, tcp::socket socket) {
      if (error == boost::asio::error::operation_aborted) return;
      if (error) return accept_later();
      admit(std::move(socket));
      accept();
    });
  }
  void accept_later() {
    pause_.expires_after(pause_after_failed_accept);
    pause_.async_wait([this](const error_code& cancelled) {
      if (!cancelled) accept();
    });
  }
  void admit(tcp::socket socket) {
    const bool is_full = static_cast<std::size_t>(open_.use_count()) > most_connections;
    if (is_full && !make_room()) return page_.count_cut_off();
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(boost::asio::socket_base::send_buffer_size(send_buffer), ignored);
    const auto session = std::make_shared<HttpSession>(std::move(socket), page_, open_);
    forget_ended();
    requests_.push_back(session);
    session->read();
  }
  /// Removes the pointers to ended sessions, because a weak pointer keeps the memory of its object.
  void forget_ended() {
    std::erase_if(requests_, [](const auto& request) { return request.expired(); });
  }
  /// Closes a connection to make room for a new one. Without this, unknown clients could occupy all
  /// connections and exclude an operator. Returns false if no connection may be closed.
  bool make_room() {
    forget_ended();
    if (requests_.empty()) return page_.make_room();
    requests_.front().lock()->close();
    requests_.pop_front();
    page_.count_cut_off();
    return true;
  }

  tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  PageService& page_;
  std::deque<std::weak_ptr<HttpSession>> requests_;  ///< connections that are not WebSockets yet; the oldest
                                                     ///< is first
  /// Counts the connections. Each connection has a copy of this pointer, so use_count() is the number of
  /// connections plus one.
  std::shared_ptr<std::size_t> open_ = std::make_shared<std::size_t>(0);
};

HttpServer::HttpServer(boost::asio::io_context& context, const std::string& address, std::uint16_t port,
                       PageService& page) {
  try {
    listener_ = std::make_unique<Listener>(context,
                                           tcp::endpoint(boost::asio::ip::make_address(address), port), page);
  } catch (const boost::system::system_error& error) {
    throw RunError(fmt::format("{}:{}", address, port), error.code().message());
  }
}

HttpServer::~HttpServer() = default;

std::uint16_t HttpServer::port() const { return listener_->port(); }
std::size_t HttpServer::sessions_kept() const { return listener_->sessions_kept(); }

}  // namespace hystcan::app
