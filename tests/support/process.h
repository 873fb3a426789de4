// Runs a program in a test as a user runs it.
#pragma once

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/scratch.h"
#include "tests/support/shipped.h"

namespace hystcan::support {

/// Standard output and error go to files that can be read while the program runs. The destructor kills it.
class Process {
 public:
  explicit Process(const std::vector<std::string>& command) {
    std::fflush(stdout);  // otherwise the child prints the buffer again
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

  /// Waits until standard error contains `text`; returns false if the program ends or `limit` passes before.
  bool says(const std::string& text, std::chrono::seconds limit = std::chrono::seconds(30)) {
    const auto deadline = std::chrono::steady_clock::now() + limit;
    while (err().find(text) == std::string::npos) {
      if (!running() || std::chrono::steady_clock::now() > deadline)
        return err().find(text) != std::string::npos;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
  }

 private:
  ScratchFolder folder_;
  pid_t child_;
  std::optional<int> status_;
  rusage usage_{};
};

}  // namespace hystcan::support
