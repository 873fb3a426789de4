// Reports when a file has been written or replaced, or a symbolic link on the way to it was. It watches the
// folders by inotify, because editors replace the file with a new one. Several changes within 0.1 s count as
// one.
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

}  // namespace hystcan::app
