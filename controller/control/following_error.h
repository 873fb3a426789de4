// Monitors the distance between stage and reference. The stage has lost its reference where, in `cycles`
// cycles in a row,
//
//   |r - y| > error_um + lag |r'|
//
// r' is the slope of the reference since the last cycle: a moving stage is behind by its lag.
#pragma once

#include <chrono>
#include <optional>

namespace hystcan::controller {

class FollowingError {
 public:
  struct Config {
    double error_um = 0.0;
    std::chrono::nanoseconds lag{0};
    unsigned cycles = 1;
  };

  explicit FollowingError(const Config& config) : config_(config) {}

  void restart() { *this = FollowingError(config_); }
  /// Called once in each cycle with a sample. False: the stage has lost its reference.
  bool step(double reference_um, double position_um, double dt_s);

 private:
  Config config_;
  std::optional<double> last_reference_um_;
  unsigned exceeded_in_a_row_ = 0;
};

}  // namespace hystcan::controller
