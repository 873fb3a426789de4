// Designs gains, notch and low pass for an identified plant.
//
// Rule: among all kp >= 0 and ki, the largest ki with
//
//   |S| = 1 / |1 + L| <= M    at every frequency and every corner of the uncertainty
//
// The integrated error of a disturbance is 1 / ki, and |S| = omega / ki at low frequencies. M bounds every
// margin at once: gain margin >= M / (M - 1), phase margin >= 2 arcsin(1 / 2 M) (Astrom, Hagglund, Advanced
// PID Control, 2006). With X the loop at ki = 1 and a given kp / ki, |1 + ki X| = 1 / M is a quadratic
// equation:
//
//   |X|^2 ki^2 + 2 Re(X) ki + 1 - 1 / M^2 = 0
//
// Its smallest positive root over all frequencies is the largest ki. From ki = 0 up to this root 1 + L is
// never zero, so the loop is as stable as with ki = 0. The phase counts: a resonance may exceed |L| = 1 if
// its phase allows that at every corner.
//
// The cautious rule allows no resonance above |L| = 1 because of its phase:
//
//   |L| <= 1 / gain_margin     where the phase of L, unwrapped from -90 degrees, is at -180 or beyond
//   |L| <= 1                   where the phase is at -180 + phase_margin or beyond
#pragma once

#include <optional>
#include <vector>

#include "controller/analysis/linear_loop.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

/// The uncertainty of the plant: each combination of the interval ends is a corner. The LoopConfig contains
/// the middle.
struct PlantUncertainty {
  model::Interval resonance_Hz;  ///< upper end is infinite if no record has shown the mode
  model::Interval damping_ratio;
  model::Interval longer_s{0.0, 0.0};  ///< added to the delays

  bool shows_mode() const;
};
/// Returns the same intervals, with the resonance wider by `percent` on both sides.
PlantUncertainty widened(PlantUncertainty uncertainty, double percent);
/// Returns the uncertainty of a configured plant: its resonance within `percent`.
PlantUncertainty around(const Delays& delays, double percent);

/// Returns the plants at the corners, and plants within the interval of the resonance. A mode above half the
/// rate appears in the samples at an alias frequency, anywhere from 0 on. The steps within the interval are
/// then shares of the rate, and they end when they have covered every alias, rising and falling. If the
/// interval has no upper end, the last plant has no mode.
std::vector<LinearLoop> corners_of(const LoopConfig& config, const PlantUncertainty& uncertainty);

struct SensitivityRule {
  double peak_sensitivity = 1.7;    ///< M > 1
  double resonance_percent = 10.0;  ///< the resonance may be this far outside its interval
};
struct CautiousRule {
  double phase_margin_deg = 60.0;
  double gain_margin = 2.0;  ///< 6 dB
};

/// Returns the largest gains with the notch and the low pass of `config`. Throws std::invalid_argument if the
/// rule is out of range.
PiGains largest_gains(const LoopConfig& config, const PlantUncertainty& uncertainty,
                      const SensitivityRule& rule);
/// Returns the largest gains by the cautious rule, for the plant of `config`. If the mode can be above half
/// the rate, both gains are reduced until the rule holds at every corner.
PiGains largest_gains(const LoopConfig& config, const PlantUncertainty& uncertainty,
                      const CautiousRule& rule);

/// Returns gains for a plant that is not measured: kp = 0, and an eighth of the largest ki that is stable at
/// every corner.
PiGains unmeasured_gains(const LoopConfig& config, const PlantUncertainty& uncertainty);

/// Returns several designs in the order of descending ki: without a filter, and with the best low pass. If a
/// record has shown the mode, also with the best deep notch, the best shallow notch, and notches of several
/// widths that cancel the mode. Which one tracks best depends on the reference: a notch also delays and
/// shapes the feed-forward. Leaves out a filter whose ki is not larger than without a filter. Ignores the
/// gains and filters of `config`.
std::vector<LoopConfig> designs(const LoopConfig& config, const PlantUncertainty& uncertainty,
                                const SensitivityRule& rule);

struct JudgedLoop {
  Margins margins;  ///< for the plant of the configuration
  Margins worst;    ///< worst value of each margin at the corners
};
JudgedLoop judge(const LoopConfig& config, const PlantUncertainty& uncertainty);

}  // namespace hystcan::controller
