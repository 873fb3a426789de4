// The local sockets: where the control socket of an interface is if no path is configured, and how a process
// listens there.
//
// Another user must not be able to put a socket there first, or `hystcan ctl` would talk to it. The socket is
// therefore in a folder of the user: the one that RUNTIME_DIRECTORY (systemd) or XDG_RUNTIME_DIR names; else
// /run/user/UID; else /tmp/hystcan-UID, which is made for it. The last two count only if they belong to the
// user and no other user can write there.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace hystcan::app {

/// The folders in which the folder of each user is. Tests have their own.
struct SocketPlaces {
  std::filesystem::path runtime = "/run/user";
  std::filesystem::path temporary = "/tmp";
  std::filesystem::path service = "/run/hystcan";  ///< of the service; only root can make it
  uid_t user = geteuid();
};

/// The socket of a controller on `interface`, hystcan-vcan0.sock, or of a twin, hystcan-twin-vcan0.sock.
/// Makes the folder in /tmp if it is needed. Throws RunError if it is not the user's own.
std::filesystem::path default_socket(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path default_twin_socket(const std::string& interface);

/// The same for a client: the first of these places where there is a socket, because /run/user/UID may have
/// come after the start of the controller, or else that of the service. Else the place of default_socket().
std::filesystem::path find_socket(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path find_twin_socket(const std::string& interface);

/// The token of the operator's page, beside the socket of the controller; the second is for one who reads it.
std::filesystem::path page_token(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path find_page_token(const std::string& interface, const SocketPlaces& places = {});

/// Listens on a Unix stream socket whose file is its own: it replaces one that a killed process has left,
/// refuses one that another process serves, and removes no other file than its own.
class LocalListener {
 public:
  using Socket = boost::asio::local::stream_protocol::socket;

  /// Calls `admit` with each connection; no next one comes until is_ready(), where it is given. Throws
  /// RunError if another process uses this socket, if there is a file that is not a socket, or if the file
  /// cannot be created. Owner and group may connect.
  LocalListener(boost::asio::io_context& context, std::filesystem::path file,
                std::function<void(Socket connection)> admit, std::function<bool()> is_ready = {});
  ~LocalListener();  ///< removes the file, unless it is no longer this socket's own
  LocalListener(const LocalListener&) = delete;
  LocalListener& operator=(const LocalListener&) = delete;

 private:
  void accept();
  void accept_after(std::chrono::milliseconds pause);

  std::filesystem::path file_;
  std::optional<std::pair<dev_t, ino_t>> id_;  ///< of the own socket file, the only one that is removed
  boost::asio::local::stream_protocol::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  std::function<void(Socket)> admit_;
  std::function<bool()> is_ready_;
  /// A handler that was due when the listener ended is called all the same, without an error.
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

}  // namespace hystcan::app
