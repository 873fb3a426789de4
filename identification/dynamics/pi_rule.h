// PI gains for a second-order mode behind a delay, and the margins of the sampled loop.
//
// With the inverse of the hysteresis the plant is linear with gain 1 (docs/theory.md). The controller closes
// the loop once per cycle (controller/control/law.h). This loop is exactly
//
//   L(z) = (kp + ki T z / (z - 1)) z^-c G(z),      z = e^{i theta},  0 < theta <= pi
//
//   G      the mode, sampled with a held drive and with its own delay (identification/dynamics/held_mode.h);
//          the hold is part of G and is not counted again
//   c      cycles from a sample to the drive that responds to it: one, the next SYNC
//
// Rule: among all kp >= 0 and ki, take the largest ki (the integrated error of a disturbance is 1 / ki) with
//
//   |L| <= 1 / gain_margin     where the phase of L, unwrapped from -90 degrees, is at -180 or beyond
//   |L| <= 1                   where it is at -180 + phase_margin or beyond
//
// The first condition keeps the resonance below the gain margin for every phase, so that no change of delay
// makes the loop unstable there. Both conditions together are sufficient for stability (Nyquist).
#pragma once

#include <complex>

#include "identification/dynamics/held_mode.h"

namespace hystcan::identification {

struct PiGains {
  double kp = 0.0;        ///< um per um
  double ki_per_s = 0.0;  ///< 1/s, > 0
};

struct PiRule {
  double phase_margin_deg = 60.0;
  double gain_margin = 2.0;  ///< 6 dB
};

struct Margins {
  bool stable = false;
  double phase_margin_deg = 0.0;  ///< the smallest of all crossovers
  double gain_margin = 0.0;       ///< the smallest; a factor
  double peak_beyond_180 = 0.0;   ///< the largest |L| at a phase of -180 degrees or beyond, unwrapped
  double peak_sensitivity = 0.0;  ///< max 1 / |1 + L|
  double crossover_Hz = 0.0;      ///< the lowest frequency of |L| = 1
  double bandwidth_Hz = 0.0;      ///< lowest frequency with |L / (1 + L)| = 1 / sqrt(2); 0 if none
};

/// The loop without its gains.
class SampledLoop {
 public:
  /// Throws std::invalid_argument if HeldMode does, or if command_cycles < 0.
  SampledLoop(const model::SecondOrder::Config& mode, double delay_s, double cycle_s, int command_cycles = 1);

  std::complex<double> operator()(const PiGains& gains, double theta) const;

  /// Throws std::invalid_argument if ki_per_s <= 0 or kp < 0.
  Margins margins(const PiGains& gains) const;
  PiGains suggest(const PiRule& rule = {}) const;

 private:
  HeldMode plant_;
  double cycle_s_;
  int command_cycles_;
  Eigen::ArrayXd theta_;      // ascending, dense around the resonance
  Eigen::ArrayXcd response_;  // z^-c G(z) at theta_
};

}  // namespace hystcan::identification
