// The rows of a stream socket (docs/control_socket.md). Connects, and connects again when the stream has ended or sends
// nothing.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/streambuf.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

namespace hystcan::app {

class StreamHandler {
 public:
  StreamHandler() = default;
  virtual ~StreamHandler() = default;
  StreamHandler(const StreamHandler&) = delete;
  StreamHandler& operator=(const StreamHandler&) = delete;

  /// Throws if it does not understand the greeting; the stream is then left.
  virtual void begun(const nlohmann::json& greeting) = 0;
  /// `values`: row by row, as the greeting says. `lost` rows before them did not come.
  virtual void received(std::span<const double> values, std::uint32_t lost) = 0;
  /// Also after every attempt that fails. Comes once before the next begun().
  virtual void ended(const std::string& reason) = 0;
};

class StreamSource {
 public:
  /// `place`: where the socket is, asked before each attempt.
  StreamSource(boost::asio::io_context& context, std::function<std::filesystem::path()> place,
               StreamHandler& handler);

 private:
  void connect();
  void read_greeting();
  void read_head();
  void read_rows(std::uint32_t rows, std::uint32_t lost);
  void await();
  void fail(const std::string& reason);

  std::function<std::filesystem::path()> place_;
  StreamHandler& handler_;
  boost::asio::local::stream_protocol::socket socket_;
  boost::asio::steady_timer limit_, pause_;
  boost::asio::streambuf received_;
  std::size_t columns_ = 0;
  std::filesystem::path file_;
  std::uint64_t attempt_ = 0;  ///< what is left of an earlier one does not count
};

}  // namespace hystcan::app
