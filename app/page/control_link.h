// A connection to a control socket that never blocks the page's thread. Commands are sent one at a time, in
// order, but `status` goes before the other waiting commands. The connection is opened when a command needs
// it. Every command gets exactly one answer; it is a refusal if no controller is running.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/streambuf.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <list>
#include <nlohmann/json.hpp>
#include <string>

namespace hystcan::app {

class ControlLink {
 public:
  using Done = std::function<void(nlohmann::json answer)>;

  /// `place`: returns the path of the socket, called before each connection. `answer_limit`: a command that
  /// gets no answer in this time is refused.
  ControlLink(boost::asio::io_context& context, std::function<std::filesystem::path()> place,
              std::chrono::seconds answer_limit);

  void ask(const nlohmann::json& command, Done done);
  /// Closes the connection, which gives up the right to write at the controller. Waiting commands that write
  /// are refused; waiting commands that read are sent over a new connection.
  void give_up_writing();
  /// Closes the connection and refuses all waiting commands.
  void close();
  bool is_busy() const { return !waiting_.empty(); }

 private:
  struct Command {
    std::string line;
    Done done;
    bool reads;
  };

  /// Wraps the handler of an asynchronous operation. If the operation failed, the connection ends. If the
  /// operation belongs to an earlier connection, its handler is not called.
  template <class Then>
  auto then(Then go_on) {
    return [this, connection = connection_, go_on](const boost::system::error_code& error, std::size_t = 0) {
      if (connection != connection_) return;
      error ? fail(error.message() + "; check that the controller is running") : go_on();
    };
  }
  void begin();
  void connect();
  void write();
  void read();
  void disconnect();
  void refuse(const std::string& reason, const std::list<Command>& commands);
  void fail(const std::string& reason);

  std::function<std::filesystem::path()> place_;
  std::chrono::seconds answer_limit_;
  boost::asio::local::stream_protocol::socket socket_;
  boost::asio::steady_timer limit_;
  boost::asio::streambuf received_;
  std::filesystem::path file_;
  std::list<Command> waiting_;
  std::uint64_t connection_ = 0;  ///< number of the current connection; results of operations
                                  ///< of earlier connections are ignored
};

}  // namespace hystcan::app
