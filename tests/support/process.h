// Runs a program in a test as a user runs it.
#pragma once

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/patience.h"
#include "tests/support/scratch.h"
#include "tests/support/shipped.h"

namespace hystcan::support {

/// Returns true if the process is hystcan with a handler for `signal`. Before exec() the process is another
/// program.
inline bool has_handler(pid_t process, int signal) {
  const std::string status = read_file("/proc/" + std::to_string(process) + "/status");
  const std::size_t at = status.find("SigCgt:");
  if (!status.starts_with("Name:\thystcan\n") || at == std::string::npos) return false;
  return (std::stoull(status.substr(at + 7), nullptr, 16) >> static_cast<unsigned>(signal - 1) & 1U) != 0;
}

/// A child process. Its standard output and error go to files that can be read while it runs. The destructor
/// kills it.
class Process {
 public:
  explicit Process(const std::vector<std::string>& command) {
    std::fflush(stdout);  // otherwise the child would print the buffer again
    child_ = fork();
    if (child_ != 0) return;
    std::vector<char*> arguments;
    for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    if (freopen((folder_ / "out").c_str(), "w", stdout) == nullptr) _exit(126);
    if (freopen((folder_ / "err").c_str(), "w", stderr) == nullptr) _exit(126);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  ~Process() {
    if (!status_) {
      send(SIGKILL);
      wait();
    }
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return child_; }
  void send(int signal) const { kill(child_, signal); }

  /// Returns the exit status, or 128 + the signal that ended the program.
  int wait() {
    if (!status_) {
      int raw = 0;
      wait4(child_, &raw, 0, &usage_);
      status_ = WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
    }
    return *status_;
  }
  bool running() {
    int raw = 0;
    if (!status_ && waitpid(child_, &raw, WNOHANG) == child_)
      status_ = WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
    return !status_;
  }
  /// Valid after wait().
  long peak_resident_kB() const { return usage_.ru_maxrss; }
  std::string out() const { return read_file(folder_ / "out"); }
  std::string err() const { return read_file(folder_ / "err"); }

  /// Waits until standard error contains `text`. Returns false if the program ends first.
  [[nodiscard]] bool says(const std::string& text) {
    const auto is_said = [&] { return err().find(text) != std::string::npos; };
    return eventually([&] { return is_said() || !running(); }) && is_said();
  }
  /// Waits until hystcan has a handler for `signal`; before that the signal would kill it. Returns false if
  /// the program ends first.
  [[nodiscard]] bool handles(int signal) {
    const auto is_handled = [&] { return has_handler(child_, signal); };
    return eventually([&] { return is_handled() || !running(); }) && is_handled();
  }

 private:
  ScratchFolder folder_;
  pid_t child_;
  std::optional<int> status_;
  rusage usage_{};
};

}  // namespace hystcan::support
