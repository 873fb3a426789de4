// The thread that serves a running controller's control socket, the watch on its configuration file and
// SIGHUP. It has an ordinary priority and shares only two lock-free rings with the control thread.
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "app/live/control_socket.h"
#include "app/live/controller_command_handler.h"
#include "app/live/live_config.h"
#include "app/live/sample_stream.h"

namespace hystcan::app {

/// Runs until the context is stopped. An exception of a handler, also of memory that is not there, ends this
/// handler and not the process.
void run_despite_exceptions(boost::asio::io_context& context);

/// Reports when a file has been written or replaced, or a symbolic link on the way to it was. It watches the
/// folders by inotify, because editors replace the file with a new one. Several changes within 0.1 s count as
/// one.
class FileWatch {
 public:
  /// If a folder cannot be watched, no change of its files is reported, and is_watching() is false.
  FileWatch(boost::asio::io_context& context, const std::vector<std::filesystem::path>& files,
            std::function<void()> on_change);

  bool is_watching() const { return watching_; }

 private:
  void read();
  bool has_watched_name(std::size_t bytes) const;
  /// Watches the folders of the files and of the targets of the links as they are now.
  void watch_folders();
  void watch(std::filesystem::path place);

  std::vector<std::filesystem::path> files_;
  std::set<std::string> names_;
  std::function<void()> on_change_;
  boost::asio::posix::stream_descriptor events_;
  boost::asio::steady_timer settle_;
  alignas(8) std::array<char, 4096> buffer_{};
  bool watching_ = false;
};

class ControlService {
 public:
  /// An empty `socket` means that there is none, and no stream beside it. Throws RunError if it cannot be
  /// opened.
  ControlService(const std::filesystem::path& config_file, const config::Config& config,
                 const std::filesystem::path& socket, CycleOutlets& outlets);
  ~ControlService();  ///< answers waiting clients and ends the thread
  ControlService(const ControlService&) = delete;
  ControlService& operator=(const ControlService&) = delete;

  controller::RequestLink& requests() { return requests_; }
  /// Reads the file again. May be called from any thread.
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
