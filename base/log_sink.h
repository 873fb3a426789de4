// The log of the program on a stream that perhaps no program reads: a pipe to a stopped program, a terminal
// after Ctrl-S.
//
// A thread that logs never waits for the reader. It puts the line into a queue, and a thread of the sink
// writes the queue. Lines that do not fit into the queue are dropped. Their number is written as soon as the
// reader goes on.
#pragma once

#include <spdlog/sinks/base_sink.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>

namespace hystcan {

class LogSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  static constexpr std::size_t most_lines = 1000;  ///< in the queue

  /// The descriptor must stay open. Lines have colours if it is a terminal.
  explicit LogSink(int descriptor);
  /// Writes what is in the queue, as long as the reader reads.
  ~LogSink() override;
  LogSink(const LogSink&) = delete;
  LogSink& operator=(const LogSink&) = delete;

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override;
  /// Waits until the queue is written, but not for a reader that does not read.
  void flush_() override;

 private:
  class Queue;

  /// Starts the thread of the queue if it does not run. False if the system has no further thread.
  bool has_thread();

  std::shared_ptr<Queue> queue_;  ///< shared with the thread, which outlives the sink if it hangs in write()
  std::thread thread_;            ///< starts with the first line
  bool coloured_;
};

}  // namespace hystcan
