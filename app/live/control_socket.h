// The local control socket: a Unix stream socket. A client sends one JSON object per line and receives one
// JSON object per line as the answer, in the same order.
//
// Access is controlled by the permissions of the socket file. Only one connection at a time has the right to
// write: the first connection that changes something gets this right and keeps it until it closes. Other
// connections may still read the status, and may end something with `stop`, `disable` or `remove`.
//
// There are at most 16 connections. A further connection replaces the one that was idle longest. If none is
// idle, the further connection may only send one `stop`, within 0.1 s.
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
  /// Opens the socket `file`. Throws RunError under the same conditions as LocalListener.
  ControlSocket(boost::asio::io_context& context, std::filesystem::path file, CommandHandler& handler);
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

 private:
  class Session;

  void admit(boost::asio::local::stream_protocol::socket connection);
  bool make_place();
  void mark_as_newest(const Session& session);

  CommandHandler& handler_;
  std::vector<std::weak_ptr<Session>> sessions_;  ///< all connections, sorted by the time of the last line
                                                  ///< that the client sent; the newest is last
  std::weak_ptr<Session> last_resort_;            ///< connection beyond the maximum number; the only
                                                  ///< command that it may send is `stop`
  std::weak_ptr<Session> writer_;
  LocalListener listener_;
};

}  // namespace hystcan::app
