// The local control socket: a Unix stream socket, one JSON object a line each way, answered in order.
//
// Who may open the file may command: its permissions are the access control. One writer at a time: the first
// connection that changes anything keeps that right until it is closed; all others may look, and stop.
#pragma once

#include <sys/types.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "app/remote/command_handler.h"

namespace hystcan::app {

/// Where a controller on `interface` listens unless told otherwise: hystcan-vcan0.sock in the folder that
/// RUNTIME_DIRECTORY (systemd) or XDG_RUNTIME_DIR name, else in /tmp. A twin: hystcan-twin-vcan0.sock.
std::filesystem::path default_socket(const std::string& interface);
std::filesystem::path default_twin_socket(const std::string& interface);

/// One line. No object where the line is no command; what is nested deeper than eight is left out.
nlohmann::json parse_command(const std::string& line);

class ControlSocket {
 public:
  /// Throws RunError where another process listens there, or the file can't be made.
  ControlSocket(boost::asio::io_context& context, std::filesystem::path file, CommandHandler& handler);
  ~ControlSocket();  ///< removes the file
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

 private:
  class Session;

  void accept();

  std::filesystem::path file_;
  CommandHandler& handler_;
  boost::asio::local::stream_protocol::acceptor acceptor_;
  std::weak_ptr<Session> writer_;
};

}  // namespace hystcan::app
