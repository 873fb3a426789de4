// The page at an address, until a signal: server, service and access together.
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
  std::vector<std::string> names{};  ///< by which browsers may ask for it, beside its addresses
  bool expose = false;               ///< an address that others can reach is intended

  /// "127.0.0.1:8080", "[::1]:8080". Throws Error.
  static PageListening at(const std::string& text);
};

class PageHost {
 public:
  /// Throws Error if others could reach the address and that is not intended, RunError if it cannot
  /// be used or the page is not in this program.
  PageHost(PageOptions options, const PageListening& listening, const std::string& token);

  /// "http://127.0.0.1:8080/"; where it listens at every address, that of this machine for itself.
  std::string url() const;
  /// Until SIGINT or SIGTERM.
  void run();

 private:
  boost::asio::io_context context_{1};
  std::string address_;
  std::unique_ptr<PageService> service_;
  std::unique_ptr<HttpServer> server_;
};

}  // namespace hystcan::app
