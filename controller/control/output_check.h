// Compares what the amplifier says that it puts out with what it was told. An interlock that is open, or a supply at its limit,
// is found before the stage has far to go when it closes.
//
//   min u - m <= o <= max u + m         u: drives of the last two to three spans of time, m: 5 % of the drive's range
//
// A span is 50 ms, and at least five cycles: the output may be late by the amplifier's lag and by the age of its status. A
// status that is older than a span is not judged: that it is missing has a cause of its own.
#pragma once

#include <array>

#include "controller/control/supervisor.h"

namespace hystcan::controller {

class OutputCheck {
 public:
  /// `drive_range`: drive_max - drive_min.
  explicit OutputCheck(double drive_range) : margin_(margin_share * drive_range) {}

  void restart(double drive);
  /// Called once in each cycle of a driven axis, with the drive that was commanded last.
  void step(double drive, const AxisInput& input);
  /// For how long the output has differed without a break; 0: it agrees, or it is not known.
  double differs_for_s() const { return differs_for_s_; }

 private:
  static constexpr double margin_share = 0.05;
  struct Drives {
    double least = 0.0, most = 0.0;
  };

  double margin_;
  std::array<Drives, 3> spans_{};  ///< the present one first
  double span_s_ = 0.0;            ///< so far of the present one
  double differs_for_s_ = 0.0;
};

}  // namespace hystcan::controller
