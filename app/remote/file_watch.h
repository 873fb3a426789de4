// Tells when a file has been written or replaced: by inotify on its folder, since editors put a new file in
// the place of the old one. Several changes within a tenth of a second are one.
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
  /// Where a folder can't be watched nothing is told of its files; is_watching() says so.
  FileWatch(boost::asio::io_context& context, const std::vector<std::filesystem::path>& files,
            std::function<void()> on_change);

  bool is_watching() const { return watching_; }

 private:
  void read();
  bool concerns_us(std::size_t bytes) const;

  std::vector<std::string> names_;
  std::function<void()> on_change_;
  boost::asio::posix::stream_descriptor events_;
  boost::asio::steady_timer settle_;
  alignas(8) std::array<char, 4096> buffer_{};
  bool watching_ = false;
};

}  // namespace hystcan::app
