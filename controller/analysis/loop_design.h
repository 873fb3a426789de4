// Designs gains, notch and low pass for an identified plant.
//
//   kp, ki   gains of PI
//   L        response of the open loop (linear_loop.h)
//   S        sensitivity, S = 1 / (1 + L): how much a disturbance changes the position
//   M        allowed maximum of |S|, M > 1
//   omega    angular frequency
//   X        response of the open loop with ki = 1, for a given ratio kp / ki, so that L = ki X
//
// The rule: of all kp >= 0 and ki, take the pair with the largest ki that satisfies
//
//   |S| = 1 / |1 + L| <= M    at every frequency and every corner of the uncertainty
//
// A large ki is good, because the integrated error of a disturbance is 1 / ki, and |S| = omega / ki at low
// frequencies. M bounds every margin at once: gain margin >= M / (M - 1), phase margin >= 2 arcsin(1 / (2 M))
// (Astrom, Hagglund, Advanced PID Control, 2006). At each frequency, |1 + ki X| = 1 / M is a quadratic
// equation for ki:
//
//   |X|^2 ki^2 + 2 Re(X) ki + 1 - 1 / M^2 = 0
//
// Its smallest positive root over all frequencies is the largest ki. From ki = 0 up to this root 1 + L is
// never zero, so the loop is as stable as with ki = 0. This rule allows |L| > 1 at a resonance if the phase
// of L permits it at every corner.
//
// The cautious rule does not rely on the phase of L at a resonance:
//
//   |L| <= 1 / gain_margin     at frequencies whose phase of L, unwrapped from -90 degrees, is -180 or less
//   |L| <= 1                   at frequencies whose phase is -180 + phase_margin or less
#pragma once

#include <optional>
#include <vector>

#include "controller/analysis/linear_loop.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

/// The uncertainty of the plant, as intervals of its parameters. A corner is a combination of interval ends.
/// The nominal plant, without this uncertainty, is in LoopConfig.
struct PlantUncertainty {
  /// Frequency of the mode. The upper end is infinite if no record has shown the mode.
  model::Interval resonance_Hz;
  model::Interval damping_ratio;
  model::Interval longer_s{0.0, 0.0};  ///< range of an additional pure delay, in s

  bool shows_mode() const;
};
/// Returns the same intervals, but with the interval of the resonance widened by `percent` on both sides.
PlantUncertainty widened(PlantUncertainty uncertainty, double percent);
/// Returns the uncertainty of a configured plant: its resonance may differ by `percent`, its damping does
/// not.
PlantUncertainty around(const Delays& delays, double percent);

/// Returns the loop with each plant that a design must tolerate: the plant of `config`, the plants at the
/// corners of the uncertainty, and plants with resonances in between. A mode above half the rate appears in
/// the samples at a lower frequency, its alias. For a mode above half the rate, the resonances in between
/// have a distance of 2 % of the rate or less, and cover every possible alias. If the interval of the
/// resonance has no upper end, the last plants have no mode.
std::vector<LinearLoop> corners_of(const LoopConfig& config, const PlantUncertainty& uncertainty);

struct SensitivityRule {
  double peak_sensitivity = 1.7;    ///< maximum of 1 / |1 + L|, > 1; L: open loop
  double resonance_percent = 10.0;  ///< the resonance may be outside its interval by this percentage
};
struct CautiousRule {
  double phase_margin_deg = 60.0;
  double gain_margin = 2.0;  ///< minimum gain margin as a factor: 2 is 6 dB
};

/// Returns the gains with the largest ki that satisfy the rule at every corner, with the notch and the low
/// pass of `config`. Throws std::invalid_argument if the rule is out of range.
PiGains largest_gains(const LoopConfig& config, const PlantUncertainty& uncertainty,
                      const SensitivityRule& rule);
/// Returns the gains with the largest ki that satisfy the cautious rule for the plant of `config`. If the
/// mode can be above half the rate, reduces both gains until the rule holds at every corner.
PiGains largest_gains(const LoopConfig& config, const PlantUncertainty& uncertainty,
                      const CautiousRule& rule);

/// Returns gains for a plant that has not been measured: kp = 0, and an eighth of the largest ki that is
/// stable at every corner.
PiGains unmeasured_gains(const LoopConfig& config, const PlantUncertainty& uncertainty);

/// Returns several designs of gains and filters in the order of descending ki: one without a filter, and one
/// with the best low pass. If a record has shown the mode, adds designs with the best deep notch, with the
/// best shallow notch, and with notches of several widths that cancel the mode. Omits a design whose ki is
/// not larger than the ki without a filter. Ignores the gains and filters of `config`. Which design tracks
/// best depends on the reference, because a notch also delays and shapes the feed-forward.
std::vector<LoopConfig> designs(const LoopConfig& config, const PlantUncertainty& uncertainty,
                                const SensitivityRule& rule);

struct JudgedLoop {
  Margins margins;  ///< margins with the plant of the configuration
  Margins worst;    ///< worst value of each margin over all plants of corners_of()
};
JudgedLoop judge(const LoopConfig& config, const PlantUncertainty& uncertainty);

}  // namespace hystcan::controller
