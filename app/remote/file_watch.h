// Reports when a file has been written or replaced. It watches the folder by inotify, because editors replace
// the file with a new one. Several changes within 0.1 s count as one.
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <functional>
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

  std::vector<std::string> names_;
  std::function<void()> on_change_;
  boost::asio::posix::stream_descriptor events_;
  boost::asio::steady_timer settle_;
  alignas(8) std::array<char, 4096> buffer_{};
  bool watching_ = false;
};

}  // namespace hystcan::app
