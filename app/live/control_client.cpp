#include "app/live/control_client.h"

#include <sys/socket.h>
#include <sys/time.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <istream>
#include <string>
#include <system_error>

#include "app/live/control_protocol.h"

namespace hystcan::app {
namespace {

using boost::asio::local::stream_protocol;
using boost::system::error_code;

// Maximum length of an answer in bytes. For comparison: the status of 32 axes has about 10 000 bytes.
constexpr std::size_t longest_answer = 1'048'576;

[[noreturn]] void fail_with(int error) { throw std::system_error(error, std::generic_category()); }

/// Connects to the socket `file`. If the server's queue of new connections is full, connect() waits for at
/// most `limit`, which is set as SO_SNDTIMEO.
void connect_within(stream_protocol::socket& socket, const std::filesystem::path& file,
                    std::chrono::milliseconds limit) {
  stream_protocol::endpoint place;
  if (file.native().size() >= sizeof sockaddr_un::sun_path) fail_with(ENAMETOOLONG);
  place.path(file.string());
  error_code error;
  socket.open(place.protocol(), error);
  if (error) fail_with(error.value());
  const timeval time{.tv_sec = limit.count() / 1000, .tv_usec = limit.count() % 1000 * 1000};
  setsockopt(socket.native_handle(), SOL_SOCKET, SO_SNDTIMEO, &time, sizeof time);
  while (::connect(socket.native_handle(), place.data(), static_cast<socklen_t>(place.size())) != 0)
    if (errno != EINTR) fail_with(errno == EAGAIN ? ETIMEDOUT : errno);
}

}  // namespace

nlohmann::json ask_socket(const std::filesystem::path& file, const nlohmann::json& command,
                          std::optional<std::chrono::milliseconds> limit) {
  const auto begun = std::chrono::steady_clock::now();
  boost::asio::io_context context;
  stream_protocol::socket socket(context);
  connect_within(socket, file, limit.value_or(std::chrono::milliseconds(0)));
  boost::asio::streambuf received(longest_answer);
  std::optional<error_code> end;
  const std::string line = command.dump() + "\n";
  boost::asio::async_write(socket, boost::asio::buffer(line), [&](const error_code&, std::size_t) {
    // Reads even after a failed write: a server that has closed the connection may have sent its reason
    // before.
    boost::asio::async_read_until(socket, received, '\n',
                                  [&](const error_code& error, std::size_t) { end = error; });
  });
  limit ? context.run_until(begun + *limit) : context.run();
  if (!end) fail_with(ETIMEDOUT);
  if (*end == boost::asio::error::not_found) fail_with(EMSGSIZE);
  if (*end) fail_with(*end == boost::asio::error::eof ? ECONNRESET : end->value());
  std::istream stream(&received);
  std::string text;
  std::getline(stream, text);
  nlohmann::json answer = parse_command(text);
  if (!answer.is_object()) fail_with(EBADMSG);
  return answer;
}

}  // namespace hystcan::app
