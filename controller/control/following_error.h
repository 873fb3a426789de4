// The watch over the distance between stage and reference.
//
//   lost where  |r - y| > error_um + lag |r'|  in so many cycles in a row
//
// r' is the reference's own slope since the last cycle: a stage that moves is behind by its lag.
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
  /// Once in each cycle with a sample. False: the stage has lost its reference.
  bool step(double reference_um, double position_um, double dt_s);

 private:
  Config config_;
  std::optional<double> last_reference_um_;
  unsigned badly_ = 0;
};

}  // namespace hystcan::controller
