// Reports when a file, or a symbolic link in its path, was written or replaced. Uses inotify on the folders
// instead of the file, because editors replace a file by a new one. Several changes within 0.1 s are reported
// once.
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace hystcan::app {

class FileWatch {
 public:
  /// Calls `on_change` after a change of one of the files. If a folder cannot be watched, changes in it are
  /// not reported and is_watching() returns false.
  FileWatch(boost::asio::io_context& context, const std::vector<std::filesystem::path>& files,
            std::function<void()> on_change);

  bool is_watching() const { return watching_; }

 private:
  void read();
  bool has_watched_name(std::size_t bytes) const;
  /// Starts to watch the folder of each file. If a file is a symbolic link, also watches the folder of the
  /// target.
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

}  // namespace hystcan::app
