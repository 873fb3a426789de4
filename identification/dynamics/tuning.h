// The gains of the loop of an identified mode, with their margins.
#pragma once

#include "identification/dynamics/pi_rule.h"
#include "identification/dynamics/second_order_fit.h"

namespace hystcan::identification {

struct Tuning {
  PiGains gains;
  Margins margins;  ///< for the identified values
  /// Each margin has its worst value at the corners of the 95 % intervals of frequency, damping and delay;
  /// bandwidth and crossover have their lowest value.
  Margins worst;
};

/// The margins of these gains for the identified mode. `cycle_s` is the cycle time of the controller,
/// which may differ from that of the dataset. Throws std::invalid_argument if cycle_s <= 0, ki_per_s <= 0
/// or kp < 0.
Tuning judge(const PiGains& gains, const SecondOrderFit& fit, double cycle_s);

/// The gains of the rule for the identified values. Throws std::invalid_argument if cycle_s <= 0.
Tuning tune(const SecondOrderFit& fit, double cycle_s, const PiRule& rule = {});

}  // namespace hystcan::identification
