#include "app/live/socket_place.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/error.h"

namespace hystcan::app {
namespace {

using boost::asio::local::stream_protocol;
using boost::system::error_code;
using FileId = std::pair<dev_t, ino_t>;

/// Permissions of the socket file: owner and group may read and write. The permissions of the folder can
/// restrict the access further.
constexpr mode_t socket_mode = 0660;

constexpr auto pause_between_looks = std::chrono::milliseconds(10);
/// Pause after a failed accept(). Without this pause, the thread would retry without end while the table of
/// file descriptors is full.
constexpr auto pause_after_failure = std::chrono::milliseconds(100);

/// Returns device and inode of a socket file, which identify it. Does not follow symbolic links. Returns
/// nullopt if there is no socket.
std::optional<FileId> id_of_socket(const std::filesystem::path& file) {
  struct stat found {};
  if (lstat(file.c_str(), &found) != 0 || !S_ISSOCK(found.st_mode)) return std::nullopt;
  return FileId{found.st_dev, found.st_ino};
}

/// Removes a socket file that a killed process left. Throws RunError if a process still serves the socket, or
/// if the file is not a socket and so belongs to another program.
void remove_if_dead(boost::asio::io_context& context, const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(std::filesystem::symlink_status(file, ignored))) return;
  if (!id_of_socket(file))
    throw RunError(file, "is not a socket", expect("a new file: set another control_socket"));
  stream_protocol::socket probe(context);
  error_code error;
  probe.connect(stream_protocol::endpoint(file.string()), error);
  if (!error)
    throw RunError(file, "another process uses this socket",
                   {.remedy = "stop that process, or set another control_socket"});
  if (error == boost::asio::error::connection_refused) std::filesystem::remove(file);
}

constexpr mode_t writable_by_others = 0022;

/// Returns the reason why a folder is not safe for the user's socket; nullopt if only `user` can write to it.
/// A symbolic link is not safe, because another user may have created it.
std::optional<std::string> reason_against(const std::filesystem::path& folder, uid_t user) {
  struct stat found {};
  if (lstat(folder.c_str(), &found) != 0) return std::generic_category().message(errno);
  if (!S_ISDIR(found.st_mode)) return "the path is not a folder";
  if (found.st_uid != user) return fmt::format("the folder belongs to user {}", found.st_uid);
  if ((found.st_mode & writable_by_others) != 0) return "other users can write to the folder";
  return std::nullopt;
}

std::filesystem::path runtime_folder(const SocketPlaces& places) {
  return places.runtime / std::to_string(places.user);
}
std::filesystem::path temporary_folder(const SocketPlaces& places) {
  return places.temporary / fmt::format("hystcan-{}", places.user);
}

/// Returns the folder in the variable RUNTIME_DIRECTORY or XDG_RUNTIME_DIR. If neither is set, returns
/// /run/user/UID, if only this user can write there; otherwise nullopt.
std::optional<std::filesystem::path> given_folder(const SocketPlaces& places) {
  for (const char* variable : {"RUNTIME_DIRECTORY", "XDG_RUNTIME_DIR"})
    if (const char* folders = std::getenv(variable); folders != nullptr && *folders != '\0') {
      const std::string_view given = folders;
      // systemd may list several folders: "/run/a:/run/b".
      const bool may_be_several = variable == std::string_view("RUNTIME_DIRECTORY");
      return given.substr(0, may_be_several ? given.find(':') : std::string_view::npos);
    }
  if (!reason_against(runtime_folder(places), places.user)) return runtime_folder(places);
  return std::nullopt;
}

std::filesystem::path made_folder(const SocketPlaces& places) {
  std::filesystem::path folder = temporary_folder(places);
  mkdir(folder.c_str(), 0700);  // ignores a failure: the next line reports its reason
  if (const auto reason = reason_against(folder, places.user))
    throw RunError(folder, fmt::format("not usable for the control socket: {}", *reason),
                   expect("a folder to which only user {} can write: set control_socket", places.user));
  return folder;
}

std::string name_of(const std::string& interface) { return "hystcan-" + interface + ".sock"; }
std::string token_name_of(const std::string& interface) { return "hystcan-" + interface + ".page-token"; }

/// Searches the folders in which a client expects sockets. Returns the first file with this name and type.
std::optional<std::filesystem::path> find_file(const std::string& name, std::filesystem::file_type type,
                                               const SocketPlaces& places) {
  std::vector<std::filesystem::path> folders;
  if (const auto given = given_folder(places)) folders.push_back(*given);
  for (const auto& folder : {runtime_folder(places), temporary_folder(places)})
    if (!reason_against(folder, places.user)) folders.push_back(folder);
  folders.push_back(places.service);
  std::error_code ignored;
  for (const auto& folder : folders)
    if (std::filesystem::symlink_status(folder / name, ignored).type() == type) return folder / name;
  return std::nullopt;
}

}  // namespace

std::filesystem::path default_socket(const std::string& interface, const SocketPlaces& places) {
  const auto given = given_folder(places);
  return (given ? *given : made_folder(places)) / name_of(interface);
}

std::filesystem::path default_twin_socket(const std::string& interface) {
  return default_socket("twin-" + interface);
}

std::filesystem::path find_socket(const std::string& interface, const SocketPlaces& places) {
  const auto found = find_file(name_of(interface), std::filesystem::file_type::socket, places);
  return found ? *found : default_socket(interface, places);
}

std::filesystem::path find_twin_socket(const std::string& interface) {
  return find_socket("twin-" + interface);
}

std::filesystem::path page_token(const std::string& interface, const SocketPlaces& places) {
  return default_socket(interface, places).replace_filename(token_name_of(interface));
}

std::filesystem::path find_page_token(const std::string& interface, const SocketPlaces& places) {
  const auto found = find_file(token_name_of(interface), std::filesystem::file_type::regular, places);
  return found ? *found : page_token(interface, places);
}

LocalListener::LocalListener(boost::asio::io_context& context, std::filesystem::path file,
                             std::function<void(Socket connection)> admit, std::function<bool()> is_ready)
    : file_(std::move(file)),
      acceptor_(context),
      pause_(context),
      admit_(std::move(admit)),
      is_ready_(std::move(is_ready)) {
  remove_if_dead(context, file_);
  try {
    const stream_protocol::endpoint endpoint(file_.string());
    acceptor_.open(endpoint.protocol());
    const mode_t before = umask(~socket_mode & 0777U);
    error_code error;
    acceptor_.bind(endpoint, error);
    umask(before);
    if (error) throw boost::system::system_error(error);
    acceptor_.listen();
    id_ = id_of_socket(file_);
  } catch (const boost::system::system_error& error) {
    throw RunError(file_, fmt::format("cannot listen on this socket: {}", error.code().message()));
  }
  accept();
}

void LocalListener::accept() {
  if (is_ready_ && !is_ready_()) return accept_after(pause_between_looks);
  acceptor_.async_accept([this, alive = std::weak_ptr(alive_)](const error_code& error, Socket connection) {
    if (alive.expired()) return;
    if (error) return accept_after(pause_after_failure);
    admit_(std::move(connection));
    accept();
  });
}

void LocalListener::accept_after(std::chrono::milliseconds pause) {
  pause_.expires_after(pause);
  pause_.async_wait([this, alive = std::weak_ptr(alive_)](const error_code&) {
    if (!alive.expired()) accept();
  });
}

LocalListener::~LocalListener() {
  error_code ignored;
  acceptor_.close(ignored);
  std::error_code also_ignored;
  if (id_ && id_of_socket(file_) == id_) std::filesystem::remove(file_, also_ignored);
}

}  // namespace hystcan::app
