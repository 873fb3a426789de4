// Serves the page at an address until a signal: server, service and access together.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/page/page_service.h"

namespace hystcan::app {

struct PageListening {
  std::string address = "127.0.0.1";
  std::uint16_t port = 8080;
  std::vector<std::string> names{};  ///< names in browsers' requests, besides its addresses
  bool expose = false;               ///< true: other computers may be able to reach the address

  /// Parses an address such as "127.0.0.1:8080" or "[::1]:8080". Throws Error.
  static PageListening at(const std::string& text);
};

class PageHost {
 public:
  /// Throws Error if others could reach the address and `expose` is false; throws RunError if the address
  /// can't be used or the program does not contain the page.
  PageHost(PageOptions options, const PageListening& listening, const std::string& token);

  /// Returns, for example, "http://127.0.0.1:8080/". If the server listens at every address, returns the
  /// address for browsers on this computer.
  std::string url() const;
  /// Runs until SIGINT or SIGTERM.
  void run();

 private:
  boost::asio::io_context context_{1};
  std::string address_;
  std::unique_ptr<PageService> service_;
  std::unique_ptr<HttpServer> server_;
};

}  // namespace hystcan::app
