#include "app/live/file_watch.h"

#include <sys/inotify.h>

#include <boost/asio/buffer.hpp>
#include <chrono>
#include <cstring>
#include <utility>

namespace hystcan::app {

FileWatch::FileWatch(boost::asio::io_context& context, const std::vector<std::filesystem::path>& files,
                     std::function<void()> on_change)
    : files_(files), on_change_(std::move(on_change)), events_(context), settle_(context) {
  const int descriptor = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (descriptor < 0) return;
  events_.assign(descriptor);
  watch_folders();
  read();
}

void FileWatch::watch_folders() {
  watching_ = true;
  for (const std::filesystem::path& file : files_) watch(std::filesystem::absolute(file));
}

void FileWatch::watch(std::filesystem::path place) {
  constexpr int most_links = 40;  // the kernel follows at most this number of links, too
  for (int links = 0; links <= most_links; ++links) {
    names_.insert(place.filename().string());
    const std::filesystem::path folder = place.parent_path();
    watching_ = watching_ &&
                inotify_add_watch(events_.native_handle(), folder.c_str(), IN_CLOSE_WRITE | IN_MOVED_TO) >= 0;
    std::error_code is_no_link;
    const std::filesystem::path target = std::filesystem::read_symlink(place, is_no_link);
    if (is_no_link) return;
    place = folder / target;
  }
}

void FileWatch::read() {
  events_.async_read_some(boost::asio::buffer(buffer_),
                          [this](const boost::system::error_code& error, std::size_t bytes) {
                            if (error) return;
                            if (has_watched_name(bytes)) {
                              settle_.expires_after(std::chrono::milliseconds(100));
                              settle_.async_wait([this](const boost::system::error_code& cancelled) {
                                if (cancelled) return;
                                watch_folders();  // a symbolic link may now point to another folder
                                on_change_();
                              });
                            }
                            read();
                          });
}

/// Returns true if an event in the buffer belongs to a watched file name. `bytes`: size of the events in the
/// buffer. The kernel delivers only complete events; the length `len` of a name includes its padding.
bool FileWatch::has_watched_name(std::size_t bytes) const {
  for (std::size_t at = 0; at + sizeof(inotify_event) <= bytes;) {
    inotify_event event{};
    std::memcpy(&event, buffer_.data() + at, sizeof(event));
    const char* name = buffer_.data() + at + sizeof(event);
    if (event.len != 0 && names_.contains(name)) return true;
    at += sizeof(event) + event.len;
  }
  return false;
}

}  // namespace hystcan::app
