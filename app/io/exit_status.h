// The exit status of a command.
#pragma once

#include <stdexcept>

namespace hystcan::app {

/// Users rely on these values: 0 done, 1 failed while running, 2 bad usage, config, model or data.
enum ExitStatus : int { done = 0, failed = 1, bad_input = 2 };

/// The command failed while running; what() is the reason, in one line.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace hystcan::app
