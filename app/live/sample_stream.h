// A read-only Unix stream socket. It sends every row of a SampleBoard to each connection, for the page and
// other programs (docs/control_socket.md). It accepts no commands and reads nothing from clients.
//
//   greeting   one line of JSON: columns, units, rate, axes
//   batches    every 20 ms, even without rows:  u32 rows, u32 lost, rows * columns float64; all little-endian
//
// `lost` is the number of rows that this connection did not get since the previous batch. While a batch is
// being sent to a connection, new rows are lost for this connection. A connection is closed if it accepts no
// data for two seconds. There are at most 4 connections.
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/live/socket_place.h"

namespace hystcan::app {

/// Passes rows of numbers from the thread that creates them to the thread that sends them. If the board is
/// full, it keeps the oldest rows; new rows are dropped and counted.
class SampleBoard {
 public:
  /// `most_rows`: maximum number of rows on the board. If the board is full, put() drops new rows until
  /// take() empties the board.
  SampleBoard(std::size_t columns, std::size_t most_rows) : columns_(columns), most_rows_(most_rows) {
    values_.reserve(columns_ * most_rows_);
  }

  std::size_t columns() const { return columns_; }
  /// Sets whether any connection needs rows. If none does, the thread that creates rows checks only this flag
  /// and does not call put().
  void set_listening(bool listening) { listening_.store(listening, std::memory_order_relaxed); }
  bool is_listening() const { return listening_.load(std::memory_order_relaxed); }

  void put(std::span<const double> row) {
    const std::scoped_lock lock(mutex_);
    if (values_.size() >= columns_ * most_rows_)
      ++lost_;
    else
      values_.insert(values_.end(), row.begin(), row.end());
  }

  /// Exchanges the stored rows with `empty`: the caller gets the rows, and the board uses the memory of
  /// `empty` for new rows. Returns the number of rows that were dropped since the last call.
  std::uint32_t take(std::vector<double>& empty) {
    empty.clear();
    empty.reserve(columns_ * most_rows_);
    const std::scoped_lock lock(mutex_);
    std::swap(values_, empty);
    return std::exchange(lost_, 0);
  }

 private:
  std::size_t columns_, most_rows_;
  std::atomic<bool> listening_{false};
  std::mutex mutex_;
  std::vector<double> values_;
  std::uint32_t lost_ = 0;
};

class SampleStream {
 public:
  /// Opens the socket `file`. `greeting`: the first line for each client, without a line end. Throws RunError
  /// under the same conditions as LocalListener.
  SampleStream(boost::asio::io_context& context, std::filesystem::path file, std::string greeting,
               SampleBoard& board);
  ~SampleStream();
  SampleStream(const SampleStream&) = delete;
  SampleStream& operator=(const SampleStream&) = delete;

 private:
  class Session;

  void admit(boost::asio::local::stream_protocol::socket connection);
  void arm();
  void send();

  std::string greeting_;
  SampleBoard& board_;
  std::vector<double> values_;
  boost::asio::steady_timer timer_;
  std::vector<std::weak_ptr<Session>> sessions_;
  bool armed_ = false;
  /// Destroyed with this object. Boost.Asio may still call a handler that was due at that time, and reports
  /// no error to it. Each handler therefore has a weak_ptr to this flag, and does nothing if the weak_ptr has
  /// expired.
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
  LocalListener listener_;
};

/// Returns the path of the stream socket that belongs to a control socket: hystcan-vcan0.stream.sock for
/// hystcan-vcan0.sock.
std::filesystem::path stream_beside(const std::filesystem::path& control_socket);

}  // namespace hystcan::app
