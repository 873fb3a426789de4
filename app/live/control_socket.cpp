#include "app/live/control_socket.h"

#include <fmt/format.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <istream>
#include <optional>
#include <utility>

#include "base/error.h"

namespace hystcan::app {
namespace {

using boost::asio::local::stream_protocol;
using boost::system::error_code;

constexpr std::size_t longest_line = 65'536;
constexpr std::size_t most_sessions = 16;

constexpr auto time_for_a_stop = std::chrono::milliseconds(100);
constexpr auto time_for_its_answer = std::chrono::seconds(1);

pid_t pid_of(stream_protocol::socket& socket) {
  ucred peer{};
  socklen_t size = sizeof(peer);
  return getsockopt(socket.native_handle(), SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 ? peer.pid : 0;
}

}  // namespace

/// One client connection. The object exists while one of its asynchronous operations is pending.
class ControlSocket::Session : public std::enable_shared_from_this<Session> {
 public:
  Session(stream_protocol::socket socket, ControlSocket& owner)
      : socket_(std::move(socket)), owner_(owner), pid_(pid_of(socket_)), limit_(socket_.get_executor()) {}

  /// Returns true if this connection may be closed to make room for a new connection. This is the case if its
  /// client waits for no answer and does not have the right to send commands that write (Access::writes).
  bool is_idle() const { return !obeying_ && owner_.writer_.lock().get() != this; }
  void close() {
    error_code ignored;
    socket_.close(ignored);
  }
  /// Reads only one line, which must be the command `stop`. Closes the connection after `time_for_a_stop`.
  void read_only_a_stop() {
    stop_only_ = true;
    close_after(time_for_a_stop);
    read();
  }

  void read() {
    boost::asio::async_read_until(
        socket_, buffer_, '\n', [self = shared_from_this()](const error_code& error, std::size_t) {
          if (error == boost::asio::error::not_found)
            self->answer(refusal(fmt::format("a line is longer than {} bytes", longest_line)), true);
          else if (!error)
            self->take_line();
        });
  }

 private:
  void take_line() {
    std::istream stream(&buffer_);
    std::string line;
    std::getline(stream, line);
    const nlohmann::json command = parse_command(line);
    owner_.mark_as_newest(*this);
    if (stop_only_) return obey_if_stop(command);
    if (!command.is_object())
      return answer(
          refusal("expected one JSON object per line, nested at most eight deep, like {\"do\": \"status\"}"),
          false);
    const ControlCommand* row = find_command(command, owner_.handler_.server);
    if ((row == nullptr || row->access == Access::writes) && !become_writer())
      return answer(
          refusal(fmt::format(
              "only one client can send this command: process {} has the right to write until it disconnects",
              owner_.writer_.lock()->pid_)),
          false);
    execute(command);
  }

  void obey_if_stop(const nlohmann::json& command) {
    const ControlCommand* row = find_command(command, owner_.handler_.server);
    if (row == nullptr || row->verb != Verb::stop)
      return answer(
          refusal(fmt::format(
              "all {} connections are in use, expected stop; for another command, close one of them and "
              "connect again",
              most_sessions)),
          true);
    close_after(time_for_its_answer);
    execute(command);
  }

  void close_after(std::chrono::milliseconds time) {
    limit_.expires_after(time);
    limit_.async_wait([self = weak_from_this()](const error_code& cancelled) {
      if (const auto session = self.lock(); session && !cancelled) session->close();
    });
  }

  /// Executes a command. Until its answer is ready, only the pending wait for the client to disconnect
  /// keeps this session alive. If the client is killed during this time, the session therefore ends at once.
  /// Another client can then get the right to send commands that write (Access::writes).
  void execute(const nlohmann::json& command) {
    obeying_ = true;
    socket_.async_wait(stream_protocol::socket::wait_error,
                       [self = shared_from_this()](const error_code& error) {
                         if (!error) self->owner_.handler_.forget(self.get());
                       });
    const auto send = [waiting = weak_from_this()](const nlohmann::json& result) {
      if (const auto self = waiting.lock()) self->answer(result, self->stop_only_);
    };
    owner_.handler_.execute(command, {send, this});
  }

  bool become_writer() {
    const auto writer = owner_.writer_.lock();
    if (writer && writer.get() != this) return false;
    owner_.writer_ = weak_from_this();
    return true;
  }

  void answer(const nlohmann::json& result, bool last) {
    obeying_ = false;
    error_code ignored;
    socket_.cancel(ignored);
    out_ = result.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
    boost::asio::async_write(socket_, boost::asio::buffer(out_),
                             [self = shared_from_this(), last](const error_code& error, std::size_t) {
                               if (!error && !last) self->read();
                             });
  }

  stream_protocol::socket socket_;
  ControlSocket& owner_;
  pid_t pid_;
  boost::asio::steady_timer limit_;
  bool obeying_ = false;
  bool stop_only_ = false;
  boost::asio::streambuf buffer_{longest_line};
  std::string out_;
};

ControlSocket::ControlSocket(boost::asio::io_context& context, std::filesystem::path file,
                             CommandHandler& handler)
    : handler_(handler),
      listener_(
          context, std::move(file),
          [this](LocalListener::Socket connection) { admit(std::move(connection)); },
          [this] { return last_resort_.expired(); }) {}

void ControlSocket::admit(stream_protocol::socket connection) {
  const auto session = std::make_shared<Session>(std::move(connection), *this);
  if (!make_place()) {
    last_resort_ = session;
    return session->read_only_a_stop();
  }
  sessions_.push_back(session);
  session->read();
}

/// Makes room for a new connection; closes the longest idle one if necessary. Returns false if all
/// connections are busy.
bool ControlSocket::make_place() {
  std::erase_if(sessions_, [](const std::weak_ptr<Session>& session) { return session.expired(); });
  if (sessions_.size() < most_sessions) return true;
  const auto idle = std::ranges::find_if(
      sessions_, [](const std::weak_ptr<Session>& session) { return session.lock()->is_idle(); });
  if (idle == sessions_.end()) return false;
  idle->lock()->close();
  sessions_.erase(idle);
  return true;
}

void ControlSocket::mark_as_newest(const Session& session) {
  const auto found = std::ranges::find_if(
      sessions_, [&](const std::weak_ptr<Session>& each) { return each.lock().get() == &session; });
  if (found != sessions_.end()) std::rotate(found, found + 1, sessions_.end());
}

}  // namespace hystcan::app
