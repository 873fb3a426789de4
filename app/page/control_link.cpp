#include "app/page/control_link.h"

#include <fmt/format.h>

#include <boost/asio/post.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <istream>
#include <utility>

#include "app/live/control_protocol.h"
#include "base/error.h"

namespace hystcan::app {
namespace {

using boost::asio::local::stream_protocol;
using boost::system::error_code;

constexpr std::size_t longest_line = 1'048'576;
constexpr std::size_t most_waiting = 64;
constexpr const char* given_up = "the connection was closed";

}  // namespace

ControlLink::ControlLink(boost::asio::io_context& context, std::function<std::filesystem::path()> place,
                         std::chrono::seconds answer_limit)
    : place_(std::move(place)),
      answer_limit_(answer_limit),
      socket_(context),
      limit_(context),
      received_(longest_line) {}

void ControlLink::ask(const nlohmann::json& command, Done done) {
  const ControlCommand& row = take_command(command, Server::controller);
  const bool reads = row.access == Access::reads;
  if (!reads && waiting_.size() >= most_waiting)
    return done(refusal(fmt::format(
        "{} commands already wait for the controller; try again after its answers", most_waiting)));
  const auto place =
      row.verb == Verb::status && !waiting_.empty() ? std::next(waiting_.begin()) : waiting_.end();
  waiting_.insert(place, {command.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n",
                          std::move(done), reads});
  if (waiting_.size() == 1) begin();
}

void ControlLink::give_up_writing() {
  if (!socket_.is_open()) return;
  disconnect();
  std::list<Command> writes;
  for (Command& command : std::exchange(waiting_, {}))
    (command.reads ? waiting_ : writes).push_back(std::move(command));
  refuse(given_up, writes);
  if (is_busy()) begin();
}

void ControlLink::close() {
  if (socket_.is_open()) fail(given_up);
}

void ControlLink::begin() {
  limit_.expires_after(answer_limit_);
  limit_.async_wait([this, connection = connection_](const error_code& cancelled) {
    if (!cancelled && connection == connection_)
      fail(fmt::format("no answer within {} s", answer_limit_.count()));
  });
  socket_.is_open() ? write() : connect();
}

void ControlLink::connect() {
  try {
    file_ = place_();
    socket_.async_connect(stream_protocol::endpoint(file_.string()),
                          [this, connection = connection_](const error_code& error) {
                            if (connection != connection_) return;
                            if (error)
                              return fail(error.message() + "; check that the controller is running");
                            write();
                          });
  } catch (const std::exception& error) {
    fail(error_text(error));
  }
}

void ControlLink::write() {
  boost::asio::async_write(socket_, boost::asio::buffer(waiting_.front().line), then([this] { read(); }));
}

void ControlLink::read() {
  boost::asio::async_read_until(socket_, received_, '\n', then([this] {
                                  std::istream stream(&received_);
                                  std::string line;
                                  std::getline(stream, line);
                                  nlohmann::json answer = parse_command(line);
                                  if (!answer.is_object()) return fail("the answer is not a JSON object");
                                  const Done done = std::move(waiting_.front().done);
                                  waiting_.pop_front();
                                  limit_.cancel();
                                  if (!waiting_.empty()) begin();
                                  done(std::move(answer));
                                }));
}

void ControlLink::disconnect() {
  ++connection_;
  limit_.cancel();
  error_code ignored;
  socket_.close(ignored);
  received_.consume(received_.size());
}

void ControlLink::refuse(const std::string& reason, const std::list<Command>& commands) {
  const nlohmann::json refused = refusal(fmt::format("{}: {}", file_.string(), reason));
  for (const Command& command : commands)
    boost::asio::post(socket_.get_executor(), [done = command.done, refused] { done(refused); });
}

/// Closes the connection and refuses all waiting commands. A command that was already sent is not sent again,
/// because the controller may have executed it.
void ControlLink::fail(const std::string& reason) {
  disconnect();
  refuse(reason, std::exchange(waiting_, {}));
}

}  // namespace hystcan::app
