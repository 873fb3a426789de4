// For any bytes of clients over TCP, as HTTP and, after an upgrade, as WebSocket frames, the server closes or
// answers each connection, and still answers the next one. An input contains several connections; each begins
// with a byte for its kind and a byte for its length.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "app/page/http_server.h"
#include "app/page/page_service.h"
#include "tests/fuzz/demand.h"

using namespace hystcan;

namespace {

class Client {
 public:
  Client(boost::asio::io_context& context, std::uint16_t port)
      : context_(context), socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    fuzz::demand(::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }
  ~Client() {
    ::close(socket_);
    context_.poll();
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Sends the input and returns the received data once the server has nothing more to do.
  std::string say(std::string_view bytes) const {
    static_cast<void>(::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL));
    std::string answer;
    std::array<char, 4096> chunk{};
    for (int idle = 0; idle < 2;) {
      idle = context_.poll() == 0 ? idle + 1 : 0;
      for (ssize_t got = 0; (got = ::recv(socket_, chunk.data(), chunk.size(), MSG_DONTWAIT)) > 0;)
        answer.append(chunk.data(), static_cast<std::size_t>(got));
    }
    return answer;
  }

 private:
  boost::asio::io_context& context_;
  int socket_;
};

constexpr std::string_view upgrade =
    "GET /socket HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n";

/// One server for all inputs, like a page that runs for weeks.
struct Page {
  boost::asio::io_context context;
  std::function<std::filesystem::path()> nowhere = [] { return "/nonexistent/control.sock"; };
  app::PageService service{context,
                           {.config = "none.toml", .controller_socket = nowhere, .twin_socket = nowhere},
                           app::PageAccess({}, "00112233445566778899aabbccddeeff")};
  app::HttpServer server{context, "127.0.0.1", 0, service};
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spdlog::set_level(spdlog::level::off);
  static Page page;
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  for (int connection = 0; connection < 4 && rest.size() > 2; ++connection) {
    const bool is_web_socket = (rest[0] & 1) != 0;
    const std::string_view bytes = rest.substr(2, 8 * static_cast<unsigned char>(rest[1]));
    rest.remove_prefix(2 + bytes.size());
    const Client client(page.context, page.server.port());
    if (is_web_socket) fuzz::demand(client.say(upgrade).starts_with("HTTP/1.1 101 "));
    const std::string answer = client.say(bytes);
    fuzz::demand(is_web_socket || answer.empty() || answer.starts_with("HTTP/1."));
  }
  const Client next(page.context, page.server.port());
  fuzz::demand(next.say("GET /none HTTP/1.1\r\nHost: localhost\r\n\r\n").starts_with("HTTP/1.1 404 "));
  return 0;
}
