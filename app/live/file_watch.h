// Reports when a file was written or replaced, or a symbolic link in its path was. Watches the folders by
// inotify, because editors replace the file by a new one. Several changes within 0.1 s count as one.
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
  /// If a folder can't be watched, changes of its files are not reported, and is_watching() is false.
  FileWatch(boost::asio::io_context& context, const std::vector<std::filesystem::path>& files,
            std::function<void()> on_change);

  bool is_watching() const { return watching_; }

 private:
  void read();
  bool has_watched_name(std::size_t bytes) const;
  /// Watches the present folders of the files and of the link targets.
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
