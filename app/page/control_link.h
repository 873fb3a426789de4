// A connection to a control socket that does not block: commands are answered in order, but `status` is sent
// before waiting commands. Connects when there is a command. Every command gets one answer, also if no
// controller is running.
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

  /// `place`: returns the path of the socket; called before each connection. A command without an answer
  /// within `answer_limit` fails.
  ControlLink(boost::asio::io_context& context, std::function<std::filesystem::path()> place,
              std::chrono::seconds answer_limit);

  void ask(const nlohmann::json& command, Done done);
  /// Gives up the right to write: unanswered commands that write are refused; those that read continue over a
  /// new connection.
  void give_up_writing();
  /// Answers all commands in progress as refused.
  void close();
  bool is_busy() const { return !waiting_.empty(); }

 private:
  struct Command {
    std::string line;
    Done done;
    bool reads;
  };

  /// Wraps the handler of an operation of this connection: an error ends the connection, and operations of an
  /// earlier connection are ignored.
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
  std::uint64_t connection_ = 0;  ///< number of the connection, to ignore operations of earlier ones
};

}  // namespace hystcan::app
