// Writes the program's log to a stream that may have no active reader: a pipe to a stopped program, or a
// terminal after Ctrl-S.
//
// A thread that logs never waits for the reader. It puts the line into a queue, and a thread of the sink
// writes the queue. Lines that do not fit into the queue are dropped. Their number is written as soon as the
// reader continues.
#pragma once

#include <spdlog/sinks/base_sink.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>

namespace hystcan {

class LogSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  static constexpr std::size_t most_lines = 1000;  ///< maximum length of the queue

  /// `descriptor` must stay open. Lines have colours if it is a terminal.
  explicit LogSink(int descriptor);
  /// Writes the queue while the reader reads.
  ~LogSink() override;
  LogSink(const LogSink&) = delete;
  LogSink& operator=(const LogSink&) = delete;

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override;
  /// Waits until the queue is written, but stops waiting if the reader does not read.
  void flush_() override;

 private:
  class Queue;

  /// Starts the thread of the queue if it is not running. Returns false if the system cannot start a thread.
  bool has_thread();

  /// Shared with the thread, which outlives the sink if it is blocked in write().
  std::shared_ptr<Queue> queue_;
  std::thread thread_;  ///< starts when the first line is logged
  bool coloured_;
};

}  // namespace hystcan
