// A small HTTP and WebSocket server on one thread. PageService decides what is served, who is refused, and
// what a message means. Only http_server.cpp uses Boost.Beast.
//
// Limits, independent of the client's behaviour: 32 connections (the oldest without a request is closed for a
// new one); a header of 8 KiB within 10 s and no body; a message of 16 KiB; data that waits for a slow
// client: 1 MiB of rows (further rows are dropped and counted) and 8 MiB in total (the client is
// disconnected). A client that reads nothing for 5 s is disconnected.
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
  std::string method, target, host, origin;  ///< host, origin: empty if missing
  std::string accept{};                      ///< header Accept
  std::string local_address{};               ///< server address of the connection, without port: "127.0.0.1"
};

struct HttpResponse {
  unsigned status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body{};
};

/// float64 rows after a head of four numbers: kind, rows, lost, capture (docs/page_protocol.md).
using RowBlock = std::shared_ptr<const std::vector<double>>;
using RowHead = std::array<std::uint32_t, 4>;

/// A client at the WebSocket. It exists from opened() to closed().
class WebClient {
 public:
  WebClient() = default;
  virtual ~WebClient() = default;
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  virtual void send_text(std::string text) = 0;
  /// Returns false if so much data waits for the client that rows are dropped.
  virtual bool takes_rows() const = 0;
  /// Returns takes_rows(); if false, nothing was sent.
  virtual bool send_rows(const RowHead& head, const RowBlock& rows) = 0;
  virtual void cut_off() = 0;
};

class PageService;

class HttpServer {
 public:
  /// Port 0 selects any free port. Throws RunError if the address can't be used.
  HttpServer(boost::asio::io_context& context, const std::string& address, std::uint16_t port,
             PageService& page);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  std::uint16_t port() const;
  /// Returns the number of HTTP sessions in memory, including those that ended since the last connection.
  std::size_t sessions_kept() const;

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace hystcan::app
