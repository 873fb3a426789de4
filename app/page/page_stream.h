// Reads one stream socket (docs/control_socket.md) and prepares its rows for the page's clients. All clients
// with the same rate share a lane, in which the rows of this rate are computed once. If the stream ends or
// sends nothing, connects again.
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
    std::function<void()> changed;                         ///< called when the stream begins or ends
    std::function<void(std::span<const double> row)> row;  ///< called for each row, after the row was added
                                                           ///< to the history
    std::function<void(std::uint32_t lost)> batch;         ///< called after each batch of rows, which
                                                           ///< rows_at() then returns; `lost`: number of
                                                           ///< rows that were lost before the batch
  };

  /// `kind`: number of this stream in binary messages to clients. `control_socket`: returns the path of the
  /// control socket, beside which the stream socket is; called before each attempt to connect.
  PageStream(boost::asio::io_context& context, std::string name, std::uint32_t kind,
             std::function<std::filesystem::path()> control_socket, Hooks hooks);

  std::uint32_t kind() const { return kind_; }
  bool is_there() const { return history_.has_value(); }
  /// The following two functions may be called only if is_there() is true.
  const StreamGreeting& greeting() const { return greeting_; }
  const RowHistory& history() const { return *history_; }
  /// Returns the message `stream`, which tells clients that the stream began or ended
  /// (docs/page_protocol.md).
  nlohmann::json message() const;

  /// Returns the rows of the newest batch, reduced to `rate` (rows per axis and second); null if there are
  /// none. Call it only from the hook `batch`.
  RowBlock rows_at(double rate);
  /// Returns the history, reduced to a few thousand rows, in small blocks. The blocks are small because, on
  /// one processor with a kernel that cannot be preempted, nothing else runs while the kernel accepts a
  /// block.
  std::vector<RowBlock> past() const;

 private:
  struct Lane {
    RowDecimator decimator;
    std::uint64_t batch = 0;  ///< number of the batch for which `rows` was computed
    RowBlock rows{};
  };

  /// Wraps the handler of an asynchronous operation. If the operation failed, the connection ends. If the
  /// operation belongs to an earlier attempt to connect, its handler is not called.
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
  /// Starts the history for a new stream. Throws if the greeting is invalid.
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
  std::uint64_t attempt_ = 0;  ///< number of the current attempt to connect; results of operations of
                               ///< earlier attempts are ignored
  StreamGreeting greeting_;
  std::string reason_ = "not connected yet";
  std::size_t axis_ = 0;  ///< index of the column with the axis number
  std::optional<RowHistory> history_;
  std::uint64_t batch_ = 0, batch_begin_ = 0;  ///< number of the newest batch, and the number of its first
                                               ///< row
  std::map<double, Lane> lanes_;
};

}  // namespace hystcan::app
