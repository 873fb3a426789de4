// The thread that serves a running controller's control socket, watches its configuration file, and handles
// SIGHUP. It has an ordinary priority and shares only two lock-free rings with the control thread.
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

/// Runs until the context is stopped. An exception of a handler, including lack of memory, ends this handler
/// and not the process.
void run_despite_exceptions(boost::asio::io_context& context);

class ControlService {
 public:
  /// `files`: the cache of LiveConfig. If `socket` is empty, there is neither a socket nor a stream. Throws
  /// RunError if the socket can't be opened.
  ControlService(const std::filesystem::path& config_file, const config::Config& config,
                 config::ReadFiles files, const std::filesystem::path& socket, CycleOutlets& outlets);
  ~ControlService();  ///< answers waiting clients and ends the thread
  ControlService(const ControlService&) = delete;
  ControlService& operator=(const ControlService&) = delete;

  controller::RequestLink& requests() { return requests_; }
  /// Reads the file again. Any thread may call it.
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
