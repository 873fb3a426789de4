// A small HTTP and WebSocket server on one thread. PageService decides which files are served, which clients
// are refused, and what a message means. Only http_server.cpp uses Boost.Beast.
//
// Limits, which no client can exceed:
//   - 32 connections; for a new one, the oldest connection without a request is closed,
//   - a request header of 8 KiB within 10 s, and no request body; a WebSocket message of 16 KiB,
//   - data that waits for a slow client: 1 MiB for rows (more rows are dropped and counted), 8 MiB in total
//     (the client is disconnected). A client that reads nothing for 5 s is also disconnected.
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::app {

struct HttpRequest {
  std::string method, target, host, origin;  ///< header fields `host` and `origin` are empty if they are
                                             ///< missing
  std::string accept{};                      ///< header field Accept
  std::string local_address{};               ///< address of this server that the client used, without port:
                                             ///< "127.0.0.1"
};

struct HttpResponse {
  unsigned status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body{};
};

/// A binary message: a head of four numbers (kind, rows, lost, capture) and then the rows as float64
/// (docs/page_protocol.md).
using RowBlock = std::shared_ptr<const std::vector<double>>;
using RowHead = std::array<std::uint32_t, 4>;

/// A client connected to the WebSocket. The object exists from PageService::opened() to
/// PageService::closed().
class WebClient {
 public:
  WebClient() = default;
  virtual ~WebClient() = default;
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  virtual void send_text(std::string text) = 0;
  /// Returns true if the client can get rows now. Returns false if too much data already waits for this
  /// client; rows are then dropped.
  virtual bool takes_rows() const = 0;
  /// Sends rows if takes_rows() is true. Otherwise sends nothing and returns false.
  virtual bool send_rows(const RowHead& head, const RowBlock& rows) = 0;
  virtual void cut_off() = 0;
};

class PageService;

class HttpServer {
 public:
  /// Starts to listen. Port 0 selects any free port. Throws RunError if the address cannot be used.
  HttpServer(boost::asio::io_context& context, const std::string& address, std::uint16_t port,
             PageService& page);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  std::uint16_t port() const;
  /// Returns the number of HTTP sessions in memory. A session that has ended counts until the next connection
  /// is accepted.
  std::size_t sessions_kept() const;

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace hystcan::app
