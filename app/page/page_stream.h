// One stream socket (docs/control_socket.md), prepared for the clients of the page: each lane has the rows of
// one rate, computed once for all clients with that rate. Reconnects when the stream ended or sends nothing.
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
    std::function<void()> changed;                         ///< the stream began or ended
    std::function<void(std::span<const double> row)> row;  ///< a row arrived, and is in the history
    std::function<void(std::uint32_t lost)> batch;         ///< a batch arrived; rows_at() returns its rows
  };

  /// `kind`: number of this stream in binary messages to clients. `control_socket`: returns the path of the
  /// control socket in the stream's folder; called before each attempt to connect.
  PageStream(boost::asio::io_context& context, std::string name, std::uint32_t kind,
             std::function<std::filesystem::path()> control_socket, Hooks hooks);

  std::uint32_t kind() const { return kind_; }
  bool is_there() const { return history_.has_value(); }
  /// Only valid if is_there().
  const StreamGreeting& greeting() const { return greeting_; }
  const RowHistory& history() const { return *history_; }
  /// Returns the message `stream` for clients.
  nlohmann::json message() const;

  /// Returns the rows of the present batch at this rate, in rows per axis and second; null if there are none.
  /// Call it from the hook `batch`.
  RowBlock rows_at(double rate);
  /// Returns the history as a few thousand rows, in small blocks: on one processor, a kernel that is not
  /// preemptible does nothing else while it accepts a block.
  std::vector<RowBlock> past() const;

 private:
  struct Lane {
    RowDecimator decimator;
    std::uint64_t batch = 0;  ///< number of the batch to which `rows` belong
    RowBlock rows{};
  };

  /// Wraps the handler of an operation of this attempt: an error ends the attempt, and operations of an
  /// earlier attempt are ignored.
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
  /// Throws if the greeting is invalid.
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
  std::uint64_t attempt_ = 0;  ///< number of the attempt, to ignore operations of earlier ones
  StreamGreeting greeting_;
  std::string reason_ = "not connected yet";
  std::size_t axis_ = 0;  ///< column that contains the axis of a row
  std::optional<RowHistory> history_;
  std::uint64_t batch_ = 0, batch_begin_ = 0;  ///< number of the present batch, and of its first row
  std::map<double, Lane> lanes_;
};

}  // namespace hystcan::app
