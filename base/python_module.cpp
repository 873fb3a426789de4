#include "base/python_module.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>
#include <utility>

namespace hystcan {
namespace {

namespace fs = std::filesystem;

std::string interpreter() {
  const char* const own = std::getenv("HYSTCAN_PYTHON");
  return own == nullptr || *own == '\0' ? "/usr/bin/python3" : own;
}

/// Returns the file in the Python package that is installed below `prefix`; empty if there is none. Debian
/// uses the folder lib/python3/dist-packages; in /usr/local its name is lib/python3.11/dist-packages.
fs::path installed_file(const fs::path& prefix, std::string_view name) {
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(prefix / "lib", none)) {
    if (!entry.path().filename().string().starts_with("python3")) continue;
    if (auto file = entry.path() / "dist-packages/hystcan" / name; fs::exists(file, none)) return file;
  }
  return {};
}

pid_t spawned(const std::vector<std::string>& words, int stream, int messages) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, stream, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, stream, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, messages, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  pid_t child = -1;
  errno = posix_spawnp(&child, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return errno == 0 ? child : -1;
}

}  // namespace

fs::path python_file(std::string_view name) {
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none).parent_path();
  if (auto installed = installed_file(program.parent_path(), name); !installed.empty()) return installed;
  // Number of folders that are searched, from the folder of the program up to the source tree. A test, in
  // BUILD/PRESET/tests/FOLDER, needs all of them.
  constexpr int levels = 5;
  fs::path above = program;
  for (int i = 0; i < levels; ++i, above = above.parent_path())
    if (auto of_the_tree = above / "python/hystcan" / name; fs::exists(of_the_tree, none)) return of_the_tree;
  return {};
}

PythonModule::PythonModule(std::string_view name, std::vector<std::string> arguments,
                           std::string_view package)
    : package_(package) {
  const std::string file = fmt::format("{}.py", name);
  const fs::path found = python_file(file);
  if (found.empty()) {
    failure_ = fmt::format("hystcan/{} is missing; install python3-hystcan", file);
    return;
  }
  arguments.insert(arguments.begin(), {interpreter(), found.string()});
  start(arguments);
}

void PythonModule::start(const std::vector<std::string>& words) {
  std::array<int, 2> ends{-1, -1};
  messages_ = ::memfd_create("messages", MFD_CLOEXEC);
  if (messages_ < 0 || ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    failure_ = std::generic_category().message(errno);
    return;
  }
  stream_ = ends[0];
  child_ = spawned(words, ends[1], messages_);
  if (child_ < 0)
    failure_ = fmt::format("{} cannot be started: {}; install {}", words.front(),
                           std::generic_category().message(errno), package_);
  ::close(ends[1]);
}

bool PythonModule::write(std::string_view bytes) {
  while (child_ >= 0 && !bytes.empty()) {
    const ssize_t sent = ::send(stream_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return child_ >= 0;
}

bool PythonModule::read(std::span<char> bytes) {
  while (child_ >= 0 && !bytes.empty()) {
    const ssize_t received = ::recv(stream_, bytes.data(), bytes.size(), MSG_WAITALL);
    if (received < 0 && errno == EINTR) continue;
    if (received <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(received));
  }
  return child_ >= 0;
}

std::optional<std::string> PythonModule::finish() {
  if (child_ >= 0) {
    ::shutdown(stream_, SHUT_RDWR);
    int status = 0;
    while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
    if (status != 0) failure_ = last_message();
  }
  for (int* const file : {&stream_, &messages_})
    if (*file >= 0) ::close(std::exchange(*file, -1));
  return failure_;
}

std::string PythonModule::last_message() const {
  std::array<char, 4096> block{};
  const off_t end = ::lseek(messages_, 0, SEEK_END);
  const ssize_t size = ::pread(messages_, block.data(), block.size(),
                               std::max<off_t>(0, end - static_cast<off_t>(block.size())));
  std::string_view text(block.data(), static_cast<std::size_t>(std::max<ssize_t>(0, size)));
  while (text.ends_with('\n')) text.remove_suffix(1);
  text.remove_prefix(text.rfind('\n') + 1);
  // An empty text has two possible causes: a library ended Python because a write failed, or the disk had no
  // room for the message.
  return text.empty() ? "Python ended without a message: Input/output error; is the disk full?"
                      : std::string(text);
}

}  // namespace hystcan
