// The paths of the local sockets, and a listener that owns its socket file.
//
// Another user must not be able to create a socket at the same path first, because `hystcan ctl` would
// connect to the wrong program. The socket is therefore in a folder of the user: the folder named by
// RUNTIME_DIRECTORY (systemd) or XDG_RUNTIME_DIR; else /run/user/UID; else /tmp/hystcan-UID, which is created
// if necessary. The last two folders are used only if they belong to the user and no other user can write
// there.
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

/// The folders in which the program creates sockets and searches for them. `runtime` and `temporary` contain
/// a subfolder for each user. `user` is the owner of the subfolder to use. Tests use other folders.
struct SocketPlaces {
  std::filesystem::path runtime = "/run/user";
  std::filesystem::path temporary = "/tmp";
  std::filesystem::path service = "/run/hystcan";  ///< folder of the systemd service; only root can create it
  uid_t user = geteuid();
};

/// Returns the default path of a controller's socket, for example hystcan-vcan0.sock for the interface vcan0.
/// For a twin, it is hystcan-twin-vcan0.sock. Creates the folder in /tmp if no other folder is usable. Throws
/// RunError if another user can write to that folder.
std::filesystem::path default_socket(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path default_twin_socket(const std::string& interface);

/// Returns the socket to which a client should connect: the first existing one in the folders of
/// default_socket(), then the socket of the service. All folders are searched, because /run/user/UID may have
/// been created after the controller started. If no socket exists, returns default_socket().
std::filesystem::path find_socket(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path find_twin_socket(const std::string& interface);

/// Returns the path of the file with the page's access token, in the folder of the controller's socket.
/// page_token() returns where the program of the page writes the file. find_page_token() returns the first
/// existing file in the folders that find_socket() searches; without one, the same path as page_token().
std::filesystem::path page_token(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path find_page_token(const std::string& interface, const SocketPlaces& places = {});

/// Listens on a Unix stream socket and owns the socket file. Replaces a file that a killed process left, but
/// not a file that another process serves. At the end, removes only the file that it created.
class LocalListener {
 public:
  using Socket = boost::asio::local::stream_protocol::socket;

  /// Opens the socket. Calls `admit` with each new connection. If `is_ready` is given, accepts a connection
  /// only after it returned true. Throws RunError if another process uses this socket, if the file exists and
  /// is not a socket, or if the file cannot be created. The owner and the group of the file may connect.
  LocalListener(boost::asio::io_context& context, std::filesystem::path file,
                std::function<void(Socket connection)> admit, std::function<bool()> is_ready = {});
  ~LocalListener();  ///< removes the socket file, unless another program has replaced it
  LocalListener(const LocalListener&) = delete;
  LocalListener& operator=(const LocalListener&) = delete;

 private:
  void accept();
  void accept_after(std::chrono::milliseconds pause);

  std::filesystem::path file_;
  /// Device and inode of the socket file that this object created.
  std::optional<std::pair<dev_t, ino_t>> id_;
  boost::asio::local::stream_protocol::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  std::function<void(Socket)> admit_;
  std::function<bool()> is_ready_;
  /// Destroyed with this object. Boost.Asio may still call a handler that was due at that time, and reports
  /// no error to it. Each handler therefore has a weak_ptr to this flag, and does nothing if the weak_ptr has
  /// expired.
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

}  // namespace hystcan::app
