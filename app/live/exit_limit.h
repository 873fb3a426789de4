// The end of a process that has nothing left to do for its actuators, but may still wait for a disk or a reader.
#pragma once

#include <chrono>

namespace hystcan::app {

/// From its destruction on, the process ends within the limit: by itself, or with the exit status 1 and one line on
/// standard error.
class ExitLimit {
 public:
  explicit ExitLimit(std::chrono::milliseconds limit) : limit_(limit) {}
  ~ExitLimit();
  ExitLimit(const ExitLimit&) = delete;
  ExitLimit& operator=(const ExitLimit&) = delete;

 private:
  std::chrono::milliseconds limit_;
};

}  // namespace hystcan::app
