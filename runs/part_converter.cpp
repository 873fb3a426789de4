#include "runs/part_converter.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>

namespace hystcan::runs {
namespace {

/// A group of its own: Ctrl-C in the terminal is for the controller.
pid_t spawn(std::array<std::string, 5> words) {
  std::array<char*, 6> arguments{};
  for (std::size_t i = 0; i < words.size(); ++i) arguments.at(i) = words.at(i).data();
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_RDWR, 0);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  pid_t child = -1;
  const int error = posix_spawn(&child, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error == 0 ? child : -1;
}

}  // namespace

std::filesystem::path hdf5_of(std::filesystem::path part) { return part.replace_extension(".h5"); }

void PartConverter::convert(const std::filesystem::path& part) {
  std::erase_if(children_, [this](const Child& child) { return has_ended(child); });
  const pid_t pid = spawn({program_.string(), "export", part.string(), "--output", hdf5_of(part).string()});
  if (pid < 0) return warn(part);
  children_.push_back({pid, part});
}

bool PartConverter::has_ended(const Child& child) {
  int status = 0;
  if (::waitpid(child.pid, &status, WNOHANG) == 0) return false;
  if (status != 0) warn(child.part);
  return true;
}

void PartConverter::warn(const std::filesystem::path& part) {
  sink_(can::BusHealthLog::Level::warning, fmt::format("{}: was not made; hystcan export {} --hdf5 makes it",
                                                       hdf5_of(part).string(), part.string()));
}

}  // namespace hystcan::runs
