#include "base/log_sink.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/standard_streams.h"
#include "base/text.h"
#include "base/threads.h"

namespace hystcan {
namespace {

/// Maximum time that flush_() waits for the next line to be written, and the destructor of LogSink for the
/// end of the thread. They could wait forever, because the program that reads the log may have stopped
/// reading.
constexpr auto reader_timeout = std::chrono::milliseconds(500);
/// Period in which the thread checks if the program ends while it waits for the reader of the log.
constexpr auto write_slice = std::chrono::milliseconds(50);

std::string_view colour_of(spdlog::level::level_enum level) {
  if (level >= spdlog::level::err) return "\033[31m\033[1m";
  if (level == spdlog::level::warn) return "\033[33m\033[1m";
  return "\033[32m";
}

std::string note_of(std::size_t dropped) {
  return fmt::format(
      "[hystcan] [warning] {} missing in this log: the program that reads the log is too slow\n",
      counted(dropped, "line"));
}

}  // namespace

class LogSink::Queue {
 public:
  explicit Queue(int descriptor) : descriptor_(descriptor) {}

  void add(std::string line) {
    const std::scoped_lock lock(mutex_);
    if (lines_.size() >= most_lines) {
      ++dropped_;
      return;
    }
    if (dropped_ != 0) lines_.push_back(note_of(std::exchange(dropped_, 0)));
    lines_.push_back(std::move(line));
    changed_.notify_all();
  }

  /// Writes the line in the thread that logs it. Used only if the system cannot start the thread of the
  /// queue.
  void write_at_once(std::string_view line) const { write_within(descriptor_, line, write_slice); }

  /// Waits until all lines are written. Stops waiting if no line was written for `reader_timeout`.
  void wait_until_written() {
    std::unique_lock lock(mutex_);
    for (std::size_t before = written_; !is_empty(); before = written_)
      if (!changed_.wait_for(lock, reader_timeout, [&] { return is_empty() || written_ != before; })) return;
  }

  /// Requests the end of the thread and waits for it. Returns false if the thread has not ended within
  /// `reader_timeout`.
  bool end() {
    std::unique_lock lock(mutex_);
    ending_ = true;
    changed_.notify_all();
    return changed_.wait_for(lock, reader_timeout, [&] { return ended_; });
  }

  void run() {
    yield_to_the_control_thread();
    std::unique_lock lock(mutex_);
    while (!ending_) {
      changed_.wait(lock, [&] { return ending_ || !is_empty(); });
      if (!ending_) write_one(lock);
    }
    ended_ = true;
    changed_.notify_all();
  }

 private:
  bool is_empty() const { return lines_.empty() && dropped_ == 0; }

  /// Writes the first line of the queue; the line stays in the queue until it is written completely. Drops
  /// the line if the stream is closed.
  void write_one(std::unique_lock<std::mutex>& lock) {
    if (lines_.empty()) lines_.push_back(note_of(std::exchange(dropped_, 0)));
    // `rest` refers to the first line while the lock is released. It stays valid: other threads only append
    // lines, which does not move the elements of a deque.
    std::string_view rest = lines_.front();
    Written result = Written::timed_out;
    while (result == Written::timed_out && !ending_) {
      lock.unlock();
      result = write_within(descriptor_, rest, write_slice);
      lock.lock();
    }
    if (result == Written::timed_out) return;
    lines_.pop_front();
    ++written_;
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> lines_;
  int descriptor_;
  std::size_t dropped_ = 0;  ///< number of lines that were dropped since the last line was queued
  std::size_t written_ = 0;
  bool ending_ = false;
  bool ended_ = false;
};

LogSink::LogSink(int descriptor)
    : queue_(std::make_shared<Queue>(descriptor)), coloured_(isatty(descriptor) == 1) {}

LogSink::~LogSink() {
  if (!thread_.joinable()) return;
  queue_->wait_until_written();
  if (queue_->end())
    thread_.join();
  else
    thread_.detach();  // the thread is blocked in write() and cannot be joined
}

bool LogSink::has_thread() {
  if (thread_.joinable()) return true;
  try {
    thread_ = std::thread([queue = queue_] { queue->run(); });
    return true;
  } catch (const std::system_error&) {
    return false;
  }
}

void LogSink::sink_it_(const spdlog::details::log_msg& message) {
  spdlog::memory_buf_t text;
  formatter_->format(message, text);
  std::string line = printable({text.data(), text.size()});
  if (coloured_ && message.color_range_end > message.color_range_start) {
    line.insert(message.color_range_end, "\033[m");
    line.insert(message.color_range_start, colour_of(message.level));
  }
  if (has_thread())
    queue_->add(std::move(line));
  else
    queue_->write_at_once(line);
}

void LogSink::flush_() { queue_->wait_until_written(); }

}  // namespace hystcan
