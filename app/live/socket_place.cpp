#include "app/live/socket_place.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdlib>
#include <optional>
#include <system_error>
#include <vector>

#include "base/error.h"

namespace hystcan::app {
namespace {

constexpr mode_t writable_by_others = 0022;

/// Why this is not a folder of the user alone; empty if it is. A symbolic link is none: another user may have made it.
std::string reason_against(const std::filesystem::path& folder, uid_t user) {
  struct stat found {};
  if (lstat(folder.c_str(), &found) != 0) return std::generic_category().message(errno);
  if (!S_ISDIR(found.st_mode)) return "it is not a folder";
  if (found.st_uid != user) return fmt::format("it belongs to user {}", found.st_uid);
  if ((found.st_mode & writable_by_others) != 0) return "others can write there";
  return {};
}

std::filesystem::path runtime_folder(const SocketPlaces& places) {
  return places.runtime / std::to_string(places.user);
}
std::filesystem::path temporary_folder(const SocketPlaces& places) {
  return places.temporary / fmt::format("hystcan-{}", places.user);
}

/// The folder that the environment names, or the one of the login.
std::optional<std::filesystem::path> given_folder(const SocketPlaces& places) {
  for (const char* variable : {"RUNTIME_DIRECTORY", "XDG_RUNTIME_DIR"})
    if (const char* folder = std::getenv(variable); folder != nullptr && *folder != '\0') return folder;
  if (reason_against(runtime_folder(places), places.user).empty()) return runtime_folder(places);
  return std::nullopt;
}

std::filesystem::path made_folder(const SocketPlaces& places) {
  std::filesystem::path folder = temporary_folder(places);
  mkdir(folder.c_str(), 0700);  // if this fails, the folder exists or the next line says why
  if (const std::string reason = reason_against(folder, places.user); !reason.empty())
    throw RunError(fmt::format(
        "{}: no place for the control socket: {}, expected a folder of user {} alone: set control_socket",
        folder.string(), reason, places.user));
  return folder;
}

std::string name_of(const std::string& interface) { return "hystcan-" + interface + ".sock"; }

}  // namespace

std::filesystem::path default_socket(const std::string& interface, const SocketPlaces& places) {
  const auto given = given_folder(places);
  return (given ? *given : made_folder(places)) / name_of(interface);
}

std::filesystem::path default_twin_socket(const std::string& interface) {
  return default_socket("twin-" + interface);
}

std::filesystem::path find_socket(const std::string& interface, const SocketPlaces& places) {
  std::vector<std::filesystem::path> folders;
  if (const auto given = given_folder(places)) folders.push_back(*given);
  for (const auto& folder : {runtime_folder(places), temporary_folder(places)})
    if (reason_against(folder, places.user).empty()) folders.push_back(folder);
  std::error_code ignored;
  for (const auto& folder : folders)
    if (std::filesystem::is_socket(std::filesystem::symlink_status(folder / name_of(interface), ignored)))
      return folder / name_of(interface);
  return default_socket(interface, places);
}

std::filesystem::path find_twin_socket(const std::string& interface) {
  return find_socket("twin-" + interface);
}

}  // namespace hystcan::app
