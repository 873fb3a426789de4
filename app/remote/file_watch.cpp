#include "app/remote/file_watch.h"

#include <sys/inotify.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <chrono>
#include <cstring>
#include <set>
#include <utility>

namespace hystcan::app {

FileWatch::FileWatch(boost::asio::io_context& context, const std::vector<std::filesystem::path>& files,
                     std::function<void()> on_change)
    : on_change_(std::move(on_change)), events_(context), settle_(context) {
  const int descriptor = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (descriptor < 0) return;
  events_.assign(descriptor);
  std::set<std::filesystem::path> folders;
  for (const std::filesystem::path& file : files) {
    names_.push_back(file.filename().string());
    folders.insert(std::filesystem::absolute(file).parent_path());
  }
  watching_ = std::ranges::all_of(folders, [&](const std::filesystem::path& folder) {
    return inotify_add_watch(descriptor, folder.c_str(), IN_CLOSE_WRITE | IN_MOVED_TO) >= 0;
  });
  read();
}

void FileWatch::read() {
  events_.async_read_some(boost::asio::buffer(buffer_),
                          [this](const boost::system::error_code& error, std::size_t bytes) {
                            if (error) return;
                            if (has_watched_name(bytes)) {
                              settle_.expires_after(std::chrono::milliseconds(100));
                              settle_.async_wait([this](const boost::system::error_code& cancelled) {
                                if (!cancelled) on_change_();
                              });
                            }
                            read();
                          });
}

/// The kernel delivers whole events; `len` of each includes the padding of its name.
bool FileWatch::has_watched_name(std::size_t bytes) const {
  for (std::size_t at = 0; at + sizeof(inotify_event) <= bytes;) {
    inotify_event event{};
    std::memcpy(&event, buffer_.data() + at, sizeof(event));
    const char* name = buffer_.data() + at + sizeof(event);
    if (event.len != 0 && std::ranges::find(names_, std::string(name)) != names_.end()) return true;
    at += sizeof(event) + event.len;
  }
  return false;
}

}  // namespace hystcan::app
