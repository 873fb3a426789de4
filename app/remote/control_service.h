// The thread at which a running controller is reached: control socket, watched configuration file, SIGHUP.
// Its priority is an ordinary one; the control thread shares nothing with it but two lock-free rings.
#pragma once

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>

#include "app/remote/control_socket.h"
#include "app/remote/controller_command_handler.h"
#include "app/remote/file_watch.h"
#include "app/remote/live_config.h"

namespace hystcan::app {

class ControlService {
 public:
  /// `socket`: empty, there is none. Throws RunError where it can't be opened.
  ControlService(const std::filesystem::path& config_file, const config::Config& config,
                 const std::filesystem::path& socket, const StatusBoard& board);
  ~ControlService();  ///< whoever waits is told; the thread ends
  ControlService(const ControlService&) = delete;
  ControlService& operator=(const ControlService&) = delete;

  controller::RequestLink& requests() { return requests_; }
  /// From any thread: read the file again.
  void reload();

 private:
  boost::asio::io_context context_{1};
  controller::RequestLink requests_;
  LiveConfig live_;
  ControllerCommandHandler handler_;
  std::optional<ControlSocket> socket_;
  FileWatch watch_;
  std::thread thread_;
};

}  // namespace hystcan::app
