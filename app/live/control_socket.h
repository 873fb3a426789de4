// The local control socket: a Unix stream socket. A client sends one JSON object per line and receives one
// JSON object per line, in the same order.
//
// The permissions of the file are the access control. There is one writer at a time: the first connection
// that changes something keeps this right until it closes. Other connections may read the status and stop.
//
// There are at most 16 connections. One more takes the place of the connection that has been idle longest. If
// none is idle, it may still send one `stop` within 0.1 s.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <vector>

#include "app/live/command_handler.h"
#include "app/live/socket_place.h"

namespace hystcan::app {

class ControlSocket {
 public:
  /// Throws RunError as LocalListener.
  ControlSocket(boost::asio::io_context& context, std::filesystem::path file, CommandHandler& handler);
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

 private:
  class Session;

  void admit(boost::asio::local::stream_protocol::socket connection);
  bool make_place();
  void mark_as_newest(const Session& session);

  CommandHandler& handler_;
  std::vector<std::weak_ptr<Session>> sessions_;  ///< the one that sent a line last is the last
  std::weak_ptr<Session> last_resort_;            ///< the one beyond the table, which may only stop
  std::weak_ptr<Session> writer_;
  LocalListener listener_;
};

}  // namespace hystcan::app
