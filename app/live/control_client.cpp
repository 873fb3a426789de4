#include "app/live/control_client.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <string>
#include <system_error>

#include "app/live/command_handler.h"
#include "base/input_file.h"

namespace hystcan::app {
namespace {

using ClientClock = std::chrono::steady_clock;

constexpr std::size_t longest_answer = 1'048'576;  // bytes; a status of 32 axes has some 10 000

[[noreturn]] void fail_with(int error) { throw std::system_error(error, std::generic_category()); }

/// One connection, all of whose steps have one deadline.
class Connection {
 public:
  Connection(const std::filesystem::path& file, std::optional<std::chrono::milliseconds> limit) {
    if (limit) deadline_ = ClientClock::now() + *limit;
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (file.native().size() >= sizeof address.sun_path) fail_with(ENAMETOOLONG);
    file.native().copy(address.sun_path, sizeof address.sun_path - 1);
    if (socket_.get() < 0) fail_with(errno);
    connect_to(address);
  }

  /// A server that has hung up already may have said why: what it sent can still be read.
  void send(std::string_view text) {
    while (!text.empty()) {
      await(POLLOUT);
      const ssize_t sent = ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL);
      if (sent < 0 && errno == EPIPE) return;
      if (sent < 0 && errno != EAGAIN && errno != EINTR) fail_with(errno);
      text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(sent, 0)));
    }
  }

  std::string read_line() {
    std::string line;
    std::array<char, 4096> chunk{};
    while (!line.ends_with('\n')) {
      await(POLLIN);
      const ssize_t received = ::recv(socket_.get(), chunk.data(), chunk.size(), 0);
      if (received == 0) fail_with(ECONNRESET);
      if (received < 0 && errno != EAGAIN && errno != EINTR) fail_with(errno);
      line.append(chunk.data(), static_cast<std::size_t>(std::max<ssize_t>(received, 0)));
      if (line.size() > longest_answer) fail_with(EMSGSIZE);
    }
    return line;
  }

 private:
  /// A socket whose queue of new connections is full says EAGAIN at once, and poll() does not say when that
  /// ends.
  void connect_to(const sockaddr_un& address) {
    constexpr int pause_ms = 10;
    while (::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      if (errno != EAGAIN && errno != EINTR) fail_with(errno);
      if (left_ms() == 0) fail_with(ETIMEDOUT);
      ::poll(nullptr, 0, pause_ms);
    }
  }

  /// Milliseconds to the deadline; -1: there is none.
  int left_ms() const {
    if (!deadline_) return -1;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(*deadline_ - ClientClock::now());
    return static_cast<int>(std::clamp<long>(left.count(), 0, INT_MAX));
  }
  void await(short event) {
    pollfd stream{.fd = socket_.get(), .events = event, .revents = 0};
    const int ready = ::poll(&stream, 1, left_ms());
    if (ready == 0) fail_with(ETIMEDOUT);
    if (ready < 0 && errno != EINTR) fail_with(errno);
  }

  Descriptor socket_{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)};
  std::optional<ClientClock::time_point> deadline_;
};

}  // namespace

nlohmann::json ask_socket(const std::filesystem::path& file, const nlohmann::json& command,
                          std::optional<std::chrono::milliseconds> limit) {
  Connection connection(file, limit);
  connection.send(command.dump() + "\n");
  nlohmann::json answer = parse_command(connection.read_line());
  if (!answer.is_object()) fail_with(EBADMSG);
  return answer;
}

}  // namespace hystcan::app
