// Listens on a Unix stream socket whose file is its own: it replaces one that a killed process has left, refuses one that
// another process serves, and removes no other file than its own.
#pragma once

#include <sys/types.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <filesystem>
#include <optional>
#include <utility>

namespace hystcan::app {

class LocalListener {
 public:
  /// Throws RunError if another process listens there, if there is a file that is not a socket, or if the file cannot be
  /// created. Owner and group may connect.
  LocalListener(boost::asio::io_context& context, std::filesystem::path file);
  ~LocalListener();  ///< removes the file, unless it is no longer this socket's own
  LocalListener(const LocalListener&) = delete;
  LocalListener& operator=(const LocalListener&) = delete;

  boost::asio::local::stream_protocol::acceptor& acceptor() { return acceptor_; }

 private:
  std::filesystem::path file_;
  std::optional<std::pair<dev_t, ino_t>> id_;  ///< of the own socket file, the only one that is removed
  boost::asio::local::stream_protocol::acceptor acceptor_;
};

}  // namespace hystcan::app
