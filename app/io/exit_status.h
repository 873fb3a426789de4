// How a command ends.
#pragma once

#include <stdexcept>

namespace hystcan::app {

/// Exit status, a contract: 0 done, 1 failed while running, 2 bad usage, config, model or data.
enum ExitStatus : int { done = 0, failed = 1, bad_input = 2 };

/// Failed while running; what() is the reason, in one line.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace hystcan::app
