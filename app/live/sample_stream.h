// A read-only Unix stream socket: every row of a SampleBoard, to each connection, for the page and other programs
// (docs/control_socket.md). It takes no commands; what a client sends is not read.
//
//   greeting   one line of JSON: columns, units, rate, axes
//   batches    every 20 ms, also without rows:  u32 rows, u32 lost, rows * columns float64; all little-endian
//
// `lost` counts the rows since the batch before that this connection did not get. A connection has one batch under way; what
// comes meanwhile is lost to it. One that takes nothing for two seconds is closed. There are at most 4 connections.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/live/local_listener.h"
#include "app/live/sample_board.h"

namespace hystcan::app {

class SampleStream {
 public:
  /// `greeting`: without its end of line. Throws RunError as LocalListener.
  SampleStream(boost::asio::io_context& context, std::filesystem::path file, std::string greeting,
               SampleBoard& board);
  ~SampleStream();
  SampleStream(const SampleStream&) = delete;
  SampleStream& operator=(const SampleStream&) = delete;

 private:
  class Session;

  void accept();
  void admit(boost::asio::local::stream_protocol::socket connection);
  void arm();
  void send();

  LocalListener listener_;
  std::string greeting_;
  SampleBoard& board_;
  SampleBoard::Rows rows_;
  boost::asio::steady_timer timer_, pause_;
  std::vector<std::weak_ptr<Session>> sessions_;
  bool armed_ = false;
  /// A handler that was due when the stream ended is called all the same, without an error.
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

/// Of the stream beside this control socket: hystcan-vcan0.sock has hystcan-vcan0.stream.sock.
std::filesystem::path stream_beside(const std::filesystem::path& control_socket);

}  // namespace hystcan::app
