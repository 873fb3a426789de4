// Runs the service thread of a controller. This thread serves the control socket, watches the configuration
// file and handles SIGHUP. It has an ordinary priority and shares only two lock-free rings with the control
// thread.
#pragma once

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>

#include "app/live/control_socket.h"
#include "app/live/controller_command_handler.h"
#include "app/live/file_watch.h"
#include "app/live/live_config.h"
#include "app/live/sample_stream.h"

namespace hystcan::app {

/// Calls the handlers of `context` until it is stopped. If a handler throws an exception, even for lack of
/// memory, logs the exception and continues with the next handler. The process does not end.
void run_despite_exceptions(boost::asio::io_context& context);

class ControlService {
 public:
  /// `files`: cache of the configuration files that were already read, so that LiveConfig does not read
  /// unchanged files again. If the path `socket` is empty, opens neither the control socket nor the stream.
  /// Throws RunError if the control socket cannot be opened.
  ControlService(const std::filesystem::path& config_file, const config::Config& config,
                 config::ReadFiles files, const std::filesystem::path& socket, CycleOutlets& outlets);
  ~ControlService();  ///< answers the waiting clients, then ends the thread
  ControlService(const ControlService&) = delete;
  ControlService& operator=(const ControlService&) = delete;

  controller::RequestLink& requests() { return requests_; }
  /// Reads the configuration file again and applies it. Any thread may call this function.
  void reload();

 private:
  void open_stream(const std::filesystem::path& file, const std::string& greeting, SampleBoard& samples);

  boost::asio::io_context context_{1};
  controller::RequestLink requests_;
  LiveConfig live_;
  ControllerCommandHandler handler_;
  std::optional<ControlSocket> socket_;
  std::optional<SampleStream> stream_;
  FileWatch watch_;
  std::thread thread_;
};

}  // namespace hystcan::app
