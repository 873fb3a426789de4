// One stream socket (docs/control_socket.md), as the clients of the page get it: each lane has the rows of
// one rate, made once for all clients of that rate. Connects, and connects again when the stream has ended or
// sends nothing.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/streambuf.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/page/http_server.h"
#include "app/page/stream_rows.h"

namespace hystcan::app {

class PageStream {
 public:
  struct Hooks {
    std::function<void()> changed;                         ///< it has begun or ended
    std::function<void(std::span<const double> row)> row;  ///< in the history already
    std::function<void(std::uint32_t lost)> batch;         ///< rows_at() has new rows
  };

  /// `kind`: of its binary messages. `control_socket`: beside which the stream is, asked before each attempt.
  PageStream(boost::asio::io_context& context, std::string name, std::uint32_t kind,
             std::function<std::filesystem::path()> control_socket, Hooks hooks);

  std::uint32_t kind() const { return kind_; }
  bool is_there() const { return history_.has_value(); }
  /// Of a stream that is there.
  const StreamGreeting& greeting() const { return greeting_; }
  const RowHistory& history() const { return *history_; }
  /// For the client: `stream`.
  nlohmann::json message() const;

  /// For the hook `batch`: what the batch gives at this rate, rows per axis and second; null if nothing.
  RowBlock rows_at(double rate);
  /// What is in the history, in a few thousand rows. In small blocks: on one processor, a kernel that is not
  /// preemptible does nothing else while it takes a block.
  std::vector<RowBlock> past() const;

 private:
  struct Lane {
    RowDecimator decimator;
    std::uint64_t batch = 0;  ///< the last one that was asked for
    RowBlock rows{};
  };

  /// The handler of an operation of this attempt: an error ends the attempt, an earlier attempt no longer
  /// counts.
  template <class Then>
  auto then(Then go_on) {
    return [this, attempt = attempt_, go_on](const boost::system::error_code& error, std::size_t = 0) {
      if (attempt != attempt_) return;
      error ? fail(error.message()) : go_on();
    };
  }
  void connect();
  void read_greeting();
  void read_head();
  void read_rows(std::uint32_t rows, std::uint32_t lost);
  void await();
  void fail(const std::string& reason);
  /// Throws if it does not understand the greeting.
  void begin(const StreamGreeting& greeting);
  void take(std::span<const double> values, std::uint32_t lost);
  void end(const std::string& reason);

  std::string name_;
  std::uint32_t kind_;
  std::function<std::filesystem::path()> control_socket_;
  Hooks hooks_;
  boost::asio::local::stream_protocol::socket socket_;
  boost::asio::steady_timer limit_, pause_;
  boost::asio::streambuf received_;
  std::filesystem::path file_;
  std::uint64_t attempt_ = 0;  ///< what is left of an earlier one does not count
  StreamGreeting greeting_;
  std::string reason_ = "not connected yet";
  std::size_t axis_ = 0;  ///< column with the axis of a row
  std::optional<RowHistory> history_;
  std::uint64_t batch_ = 0, batch_begin_ = 0;  ///< number of the present batch, and of its first row
  std::map<double, Lane> lanes_;
};

}  // namespace hystcan::app
