// Compares what the amplifier says that it puts out with what it was told. An interlock that is open, or a supply at its limit,
// is found before the stage has far to go when it closes.
//
//   |o - u| <= m + s (age + late)       s: slew of the drive, late: four cycles and five lags of the amplifier
//   min u - m <= o <= max u + m         u: drives of the last two to three spans, m: 5 % of the drive's range
//
// The first one finds it in a ramp, whose slew is small. While the axis tracks, s is the limit of the slew, and the second
// one is the narrower one. A span is 50 ms, and at least five cycles and five lags. Each status is judged once, when it comes, and its
// verdict stands until the next one, for a span at most: that statuses are missing has a cause of its own.
#pragma once

#include <array>

#include "controller/control/supervisor.h"

namespace hystcan::controller {

class OutputCheck {
 public:
  struct Config {
    double drive_range = 0.0;  ///< drive_max - drive_min
    double lag_s = 0.0;        ///< of the amplifier
  };

  explicit OutputCheck(const Config& config) : config_(config) {}

  void restart(double drive);
  /// Called once in each cycle of a driven axis, with the drive that was commanded last, which moves by at most `slew_per_s`.
  void step(double drive, double slew_per_s, const AxisInput& input);
  /// For how long the output has differed without a break; 0: it agrees, or it is not known.
  double differs_for_s() const { return differs_for_s_; }

 private:
  struct Drives {
    double least = 0.0, most = 0.0;
  };

  bool agrees(double drive, double slew_per_s, const AxisInput& input) const;

  Config config_;
  std::array<Drives, 3> spans_{};  ///< the present one first
  double span_s_ = 0.0;            ///< so far of the present one
  double status_age_s_ = 0.0;
  bool agrees_ = true;  ///< the last status
  double differs_for_s_ = 0.0;
};

}  // namespace hystcan::controller
