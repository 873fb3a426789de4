// Writes the log of the program to a stream, although the reader of the stream may have stopped: a pipe to a
// stopped program, or a terminal after Ctrl-S.
//
// A thread that logs a line never waits for the reader: it puts the line into a queue, and another thread
// writes the lines of the queue to the stream. If the queue is full, a line is dropped. When the reader
// continues, the number of dropped lines is written to the log.
#pragma once

#include <spdlog/sinks/base_sink.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>

namespace hystcan {

class LogSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  static constexpr std::size_t most_lines = 1000;  ///< maximum number of lines in the queue

  /// Logs to the open file descriptor `descriptor`, which must stay open. The lines have colours if it is a
  /// terminal.
  explicit LogSink(int descriptor);
  /// Writes the lines of the queue as long as the reader reads them, then stops the thread.
  ~LogSink() override;
  LogSink(const LogSink&) = delete;
  LogSink& operator=(const LogSink&) = delete;

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override;
  /// Waits until all lines of the queue are written. Stops waiting if the reader does not read for half a
  /// second.
  void flush_() override;

 private:
  class Queue;

  /// Starts the thread of the queue if it is not running. Returns false if the system cannot start a thread.
  bool has_thread();

  /// The queue is also owned by the thread, because a thread that is blocked in write() runs longer than the
  /// sink.
  std::shared_ptr<Queue> queue_;
  std::thread thread_;  ///< starts when the first line is logged
  bool coloured_;
};

}  // namespace hystcan
