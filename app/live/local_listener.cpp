#include "app/live/local_listener.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include "base/error.h"

namespace hystcan::app {
namespace {

using boost::asio::local::stream_protocol;
using boost::system::error_code;
using FileId = std::pair<dev_t, ino_t>;

/// Read and write for owner and group; the permissions of the folder can restrict this further.
constexpr mode_t socket_mode = 0660;

/// Of the socket itself, not of what a link there points to; empty if there is none.
std::optional<FileId> id_of_socket(const std::filesystem::path& file) {
  struct stat found {};
  if (lstat(file.c_str(), &found) != 0 || !S_ISSOCK(found.st_mode)) return std::nullopt;
  return FileId{found.st_dev, found.st_ino};
}

/// Removes a socket file without a listener, which remains from a process that was killed. Throws RunError if
/// a process listens there, or if the file is no socket: it then belongs to another program.
void remove_if_dead(boost::asio::io_context& context, const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(std::filesystem::symlink_status(file, ignored))) return;
  if (!id_of_socket(file))
    throw RunError(
        fmt::format("{}: is not a socket, expected a new file: name another control_socket", file.string()));
  stream_protocol::socket probe(context);
  error_code error;
  probe.connect(stream_protocol::endpoint(file.string()), error);
  if (!error)
    throw RunError(fmt::format("{}: another process listens there; end it, or name another control_socket",
                               file.string()));
  if (error == boost::asio::error::connection_refused) std::filesystem::remove(file);
}

}  // namespace

LocalListener::LocalListener(boost::asio::io_context& context, std::filesystem::path file)
    : file_(std::move(file)), acceptor_(context) {
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
    throw RunError(fmt::format("{}: cannot listen there: {}", file_.string(), error.code().message()));
  }
}

LocalListener::~LocalListener() {
  error_code ignored;
  acceptor_.close(ignored);
  std::error_code also_ignored;
  if (id_ && id_of_socket(file_) == id_) std::filesystem::remove(file_, also_ignored);
}

}  // namespace hystcan::app
