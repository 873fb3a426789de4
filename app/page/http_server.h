// A small HTTP and WebSocket server on one thread. PageService says what is served, whom it refuses and what
// a message means. All of Boost.Beast is in http_server.cpp.
//
// Bounds, whatever a client does: 32 connections, of which the oldest that has asked for nothing makes room;
// a header of 8 KiB within 10 s and no body; a message of 16 KiB; what waits for a client that does not read:
// 1 MiB of rows (further rows are left out and counted) and 8 MiB in all (it is cut off). A client that takes
// nothing for 5 s is cut off.
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
  std::string method, target, host, origin;  ///< host, origin: empty if there is none
  std::string accept{};                      ///< header Accept
  std::string local_address{};               ///< of the connection, without port: "127.0.0.1"
};

struct HttpResponse {
  unsigned status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body{};
};

/// float64 rows behind a head of four numbers: kind, rows, lost, capture (docs/page_protocol.md).
using RowBlock = std::shared_ptr<const std::vector<double>>;
using RowHead = std::array<std::uint32_t, 4>;

/// A client at the WebSocket. It lives from opened() to closed().
class WebClient {
 public:
  WebClient() = default;
  virtual ~WebClient() = default;
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  virtual void send_text(std::string text) = 0;
  /// False if so much waits for the client that rows are left out.
  virtual bool takes_rows() const = 0;
  /// What takes_rows() says; if that is false, nothing was sent.
  virtual bool send_rows(const RowHead& head, const RowBlock& rows) = 0;
  virtual void cut_off() = 0;
};

class PageService;

class HttpServer {
 public:
  /// Port 0: any free one. Throws RunError if the address cannot be used.
  HttpServer(boost::asio::io_context& context, const std::string& address, std::uint16_t port,
             PageService& page);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  std::uint16_t port() const;
  /// HTTP sessions in memory, those included that ended since the last connection.
  std::size_t sessions_kept() const;

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace hystcan::app
