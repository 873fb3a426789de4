// The local sockets: the default path of an interface's control socket, and the listener on it.
//
// Another user must not be able to create a socket at this path first, because `hystcan ctl` would connect to
// it. The socket is therefore in a folder of the user: the one in RUNTIME_DIRECTORY (systemd) or
// XDG_RUNTIME_DIR; else /run/user/UID; else /tmp/hystcan-UID, which is created if necessary. The last two are
// used only if they belong to the user and no other user can write there.
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

/// The folders that contain the users' folders. Tests replace them.
struct SocketPlaces {
  std::filesystem::path runtime = "/run/user";
  std::filesystem::path temporary = "/tmp";
  std::filesystem::path service = "/run/hystcan";  ///< folder of the service; only root can create it
  uid_t user = geteuid();
};

/// Returns the socket of a controller on `interface`, hystcan-vcan0.sock, or of a twin,
/// hystcan-twin-vcan0.sock. Creates the folder in /tmp if necessary. Throws RunError if it is not the user's
/// own.
std::filesystem::path default_socket(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path default_twin_socket(const std::string& interface);

/// For a client: returns the first existing socket among these places, because /run/user/UID may have been
/// created after the start of the controller; else the service's socket; else the path of default_socket().
std::filesystem::path find_socket(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path find_twin_socket(const std::string& interface);

/// Returns the file of the operator page's token, in the folder of the controller's socket; the second
/// function is for readers of the token.
std::filesystem::path page_token(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path find_page_token(const std::string& interface, const SocketPlaces& places = {});

/// Listens on a Unix stream socket with its own file: replaces a file that a killed process left, refuses to
/// replace one that another process serves, and removes only its own file.
class LocalListener {
 public:
  using Socket = boost::asio::local::stream_protocol::socket;

  /// Calls `admit` with each connection; if `is_ready` is given, the next connection waits for it. Throws
  /// RunError if another process uses this socket, if the file exists and is not a socket, or if it can't be
  /// created. Owner and group may connect.
  LocalListener(boost::asio::io_context& context, std::filesystem::path file,
                std::function<void(Socket connection)> admit, std::function<bool()> is_ready = {});
  ~LocalListener();  ///< removes the file, unless it is no longer this socket's own
  LocalListener(const LocalListener&) = delete;
  LocalListener& operator=(const LocalListener&) = delete;

 private:
  void accept();
  void accept_after(std::chrono::milliseconds pause);

  std::filesystem::path file_;
  std::optional<std::pair<dev_t, ino_t>> id_;  ///< identifies the own socket file, the only one that is
                                               ///< removed
  boost::asio::local::stream_protocol::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  std::function<void(Socket)> admit_;
  std::function<bool()> is_ready_;
  /// Lets a handler detect that this object was destroyed: a handler that was due at that time is still
  /// called, without an error.
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

}  // namespace hystcan::app
