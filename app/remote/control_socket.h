// The local control socket: a Unix stream socket. A client sends one JSON object per line and receives one
// JSON object per line, in the same order.
//
// The permissions of the file are the access control. There is one writer at a time: the first connection
// that changes something keeps this right until it closes. Other connections may read the status and stop.
//
// There are at most 16 connections. One more takes the place of the connection that has been idle longest. If none
// is idle, it may still send one `stop` within 0.1 s.
#pragma once

#include <sys/types.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/remote/command_handler.h"

namespace hystcan::app {

class ControlSocket {
 public:
  /// Throws RunError if another process listens there, if there is a file that is not a socket, or if the file
  /// cannot be created.
  ControlSocket(boost::asio::io_context& context, std::filesystem::path file, CommandHandler& handler);
  ~ControlSocket();  ///< removes the file, unless it is no longer this socket's own
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

 private:
  class Session;

  void accept();
  void accept_after(std::chrono::milliseconds pause);
  void admit(boost::asio::local::stream_protocol::socket connection);
  bool make_place();
  void mark_as_newest(const Session& session);

  std::filesystem::path file_;
  std::optional<std::pair<dev_t, ino_t>> id_;  ///< of the own socket file, the only one that is removed
  CommandHandler& handler_;
  boost::asio::local::stream_protocol::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  std::vector<std::weak_ptr<Session>> sessions_;  ///< the one that sent a line last is the last
  std::weak_ptr<Session> last_resort_;            ///< the one beyond the table, which may only stop
  std::weak_ptr<Session> writer_;
};

}  // namespace hystcan::app
