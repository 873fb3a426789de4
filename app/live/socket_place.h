// Where the control socket of an interface is if no path is configured.
//
// Another user must not be able to put a socket there first, or `hystcan ctl` would talk to it. The socket is
// therefore in a folder of the user: the one that RUNTIME_DIRECTORY (systemd) or XDG_RUNTIME_DIR names; else
// /run/user/UID; else /tmp/hystcan-UID, which is made for it. The last two count only if they belong to the user and
// nobody else can write there.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace hystcan::app {

/// The folders in which the folder of each user is. Tests have their own.
struct SocketPlaces {
  std::filesystem::path runtime = "/run/user";
  std::filesystem::path temporary = "/tmp";
  uid_t user = geteuid();
};

/// The socket of a controller on `interface`, hystcan-vcan0.sock, or of a twin, hystcan-twin-vcan0.sock. Makes the
/// folder in /tmp if it is needed. Throws RunError if it is not the user's own.
std::filesystem::path default_socket(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path default_twin_socket(const std::string& interface);

/// The same for a client: the first of these places where there is a socket, because /run/user/UID may have come after
/// the start of the controller. Else the place of default_socket().
std::filesystem::path find_socket(const std::string& interface, const SocketPlaces& places = {});
std::filesystem::path find_twin_socket(const std::string& interface);

}  // namespace hystcan::app
