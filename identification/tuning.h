// From an identified mode to the gains that its loop may have.
#pragma once

#include "identification/pi_rule.h"
#include "identification/second_order_fit.h"

namespace hystcan::identification {

struct Tuning {
  PiGains gains;    ///< by the rule, for the values found
  Margins margins;  ///< for the values found
  /// Each the worst at the corners of the 95 % intervals of frequency, damping and delay; bandwidth and
  /// crossover the lowest.
  Margins worst;
};

/// The loop with the controller's cycle, which may be another than the record's. Throws std::invalid_argument
/// where cycle_s <= 0.
Tuning tune(const SecondOrderFit& fit, double cycle_s, const PiRule& rule = {});

}  // namespace hystcan::identification
