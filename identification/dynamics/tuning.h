// From an identified mode to the gains that its loop may have.
#pragma once

#include "identification/dynamics/pi_rule.h"
#include "identification/dynamics/second_order_fit.h"

namespace hystcan::identification {

struct Tuning {
  PiGains gains;
  Margins margins;  ///< for the values found
  /// Each the worst at the corners of the 95 % intervals of frequency, damping and delay; bandwidth and
  /// crossover the lowest.
  Margins worst;
};

/// What these gains make of the mode that was found. `cycle_s` is the controller's, which may be another than
/// the dataset's. Throws std::invalid_argument where cycle_s <= 0, ki_per_s <= 0 or kp < 0.
Tuning judge(const PiGains& gains, const SecondOrderFit& fit, double cycle_s);

/// The gains by the rule, for the values found. Throws std::invalid_argument where cycle_s <= 0.
Tuning tune(const SecondOrderFit& fit, double cycle_s, const PiRule& rule = {});

}  // namespace hystcan::identification
