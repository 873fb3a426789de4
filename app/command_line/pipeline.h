// Reads, computes and writes blocks of data in three threads at the same time.
//
//   calling thread: read ──▶ thread: compute ──▶ thread: write        blocks stay in order and are reused
//
// Only the calling thread receives signals, so that a signal interrupts its wait for input.
#pragma once

#include <pthread.h>
#include <array>
#include <condition_variable>
#include <csignal>
#include <cstddef>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "base/threads.h"

namespace hystcan::app {

template <class T>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t most) : most_(most) {}

  /// Appends a value; waits while the queue is full. Returns false if the reader abandoned the queue.
  bool push(T value) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return abandoned_ || values_.size() < most_; });
    if (abandoned_) return false;
    values_.push_back(std::move(value));
    changed_.notify_all();
    return true;
  }
  /// Removes the oldest value; waits while the queue is empty. Returns nullopt if the queue is empty and
  /// finished.
  std::optional<T> pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return finished_ || !values_.empty(); });
    if (values_.empty()) return std::nullopt;
    std::optional<T> value(std::move(values_.front()));
    values_.pop_front();
    changed_.notify_all();
    return value;
  }
  /// Called by the writer after its last push(). The reader still gets the values in the queue.
  void finish() { set(finished_); }
  /// Called by the reader if it will not call pop() again. It releases a writer that waits for space.
  void abandon() { set(abandoned_); }

 private:
  void set(bool& flag) {
    const std::scoped_lock lock(mutex_);
    flag = true;
    changed_.notify_all();
  }

  std::size_t most_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<T> values_;
  bool finished_ = false;
  bool abandoned_ = false;
};

/// Calls read, compute and write for one block after the other, in the calling thread, until read returns
/// false. run_pipeline() uses this function if the system cannot create a thread.
template <class Block, class Read, class Compute, class Write>
void run_in_sequence(Read& read, Compute& compute, Write& write) {
  for (Block block; read(block);) {
    compute(block);
    write(block);
  }
}

/// Processes blocks until the input ends. `read(Block&)` fills a block and returns false at the end of the
/// input. `compute(Block&)` and `write(const Block&)` get each block once, in order. An exception from any of
/// the three functions ends the pipeline, and run_pipeline() throws it. If several functions throw, the
/// exception that belongs to the earliest block is thrown. If the system cannot create a thread, all work is
/// done in the calling thread.
template <class Block, class Read, class Compute, class Write>
void run_pipeline(Read read, Compute compute, Write write) {
  constexpr std::size_t depth = 4;  // maximum number of blocks that wait between two threads
  BoundedQueue<Block> empty(3 * depth), filled(depth), computed(depth);
  std::exception_ptr read_error, compute_error, write_error;
  const auto take_all = [](BoundedQueue<Block>& from, BoundedQueue<Block>& to, std::exception_ptr& error,
                           auto work) {
    try {
      while (std::optional<Block> block = from.pop()) {
        work(*block);
        if (!to.push(std::move(*block))) break;
      }
    } catch (...) {
      error = std::current_exception();
    }
    from.abandon();
    to.finish();
  };
  std::thread computing, writing;
  try {
    computing = thread_without_signals([&] { take_all(filled, computed, compute_error, compute); });
    writing = thread_without_signals([&] { take_all(computed, empty, write_error, write); });
  } catch (const std::system_error&) {
    filled.finish();
    if (computing.joinable()) computing.join();
    return run_in_sequence<Block>(read, compute, write);
  }
  for (std::size_t i = 0; i < 2 * depth; ++i) empty.push(Block{});
  try {
    for (std::optional<Block> block = empty.pop(); block && read(*block); block = empty.pop())
      if (!filled.push(std::move(*block))) break;
  } catch (...) {
    read_error = std::current_exception();
  }
  filled.finish();
  computing.join();
  writing.join();
  for (const std::exception_ptr& error : {write_error, compute_error, read_error})
    if (error) std::rethrow_exception(error);
}

}  // namespace hystcan::app
