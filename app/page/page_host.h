// Serves the operator's page at an address until a signal arrives. Contains the server, its service and the
// access control.
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
  std::vector<std::string> names{};  ///< names by which browsers reach this server, in addition to its
                                     ///< addresses
  bool expose = false;               ///< true: addresses that other computers can reach are allowed

  /// Parses an address such as "127.0.0.1:8080" or "[::1]:8080". Throws Error if the text is not an address.
  static PageListening at(const std::string& text);
};

class PageHost {
 public:
  /// Starts the server. Throws Error if other computers could reach the address and `expose` is false. Throws
  /// RunError if the address cannot be used, or if the program was built without the page.
  PageHost(PageOptions options, const PageListening& listening, const std::string& token);

  /// Returns the URL of the page, for example "http://127.0.0.1:8080/". If the server listens at all
  /// addresses, the URL is for browsers on this computer.
  std::string url() const;
  /// Serves the page until SIGINT or SIGTERM arrives.
  void run();

 private:
  boost::asio::io_context context_{1};
  std::string address_;
  std::unique_ptr<PageService> service_;
  std::unique_ptr<HttpServer> server_;
};

}  // namespace hystcan::app
