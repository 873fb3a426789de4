// Gains, notch and low pass for an identified plant.
//
// Rule: among all kp >= 0 and ki, the largest ki with
//
//   |S| = 1 / |1 + L| <= M    at every frequency and every corner of what is uncertain
//
// The integrated error of a disturbance is 1 / ki, and |S| = omega / ki at low frequencies. M bounds every
// margin at once: gain margin >= M / (M - 1), phase margin >= 2 arcsin(1 / 2 M) (Astrom, Hagglund, Advanced
// PID Control, 2006). With X the loop at ki = 1 and a given kp / ki, |1 + ki X| = 1 / M is a quadratic
// equation:
//
//   |X|^2 ki^2 + 2 Re(X) ki + 1 - 1 / M^2 = 0
//
// Its smallest positive root over all frequencies is the largest ki. From ki = 0 to there |1 + L| never comes
// to zero, so the loop is stable like that of ki = 0. The phase counts: a resonance may stand out of the unit
// circle where its phase allows that at every corner.
//
// The cautious rule counts no phase at and beyond -180 degrees, so that no delay makes the loop unstable:
//
//   |L| <= 1 / gain_margin     where the phase of L, unwrapped from -90 degrees, is at -180 or beyond
//   |L| <= 1                   where it is at -180 + phase_margin or beyond
#pragma once

#include <optional>
#include <vector>

#include "controller/analysis/linear_loop.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

/// What the plant may be: the corners of these intervals. The middle is the LoopConfig's.
struct PlantUncertainty {
  model::Interval resonance_Hz;  ///< up to infinity where no record has shown the mode
  model::Interval damping_ratio;
  model::Interval longer_s{0.0, 0.0};  ///< added to the delays

  bool shows_mode() const;
};
/// These intervals, with the resonance wider by `percent` on both sides.
PlantUncertainty widened(PlantUncertainty uncertainty, double percent);
/// What is known of a configured plant: its resonance within `percent`.
PlantUncertainty around(const Delays& delays, double percent);

/// The plants at the corners, and within the interval of the resonance. Above half the rate the samples show
/// a mode as another one, anywhere from 0 on: the steps within the interval are then shares of the rate. They
/// end where the samples have shown all of these, rising and falling. Without an upper end the last plant has
/// no mode.
std::vector<LinearLoop> corners_of(const LoopConfig& config, const PlantUncertainty& uncertainty);

struct SensitivityRule {
  double peak_sensitivity = 1.7;    ///< M > 1
  double resonance_percent = 10.0;  ///< the resonance may be this far outside its interval
};
struct CautiousRule {
  double phase_margin_deg = 60.0;
  double gain_margin = 2.0;  ///< 6 dB
};

/// The largest gains with the notch and the low pass of `config`. Throws std::invalid_argument where the rule
/// is out of range.
PiGains largest_gains(const LoopConfig& config, const PlantUncertainty& uncertainty,
                      const SensitivityRule& rule);
/// The same by the cautious rule, for the plant of `config`; where the samples fold the mode, with less of
/// both so that it holds at every corner.
PiGains largest_gains(const LoopConfig& config, const PlantUncertainty& uncertainty,
                      const CautiousRule& rule);

/// An integral gain alone, an eighth of what is stable at every corner: for a plant that is not measured.
PiGains unmeasured_gains(const LoopConfig& config, const PlantUncertainty& uncertainty);

/// Gains without a filter, with the best low pass, and where a record has shown the mode with the best deep
/// notch, the best shallow one, and notches of several widths that cancel the mode, in the order of
/// descending ki. Which one tracks best depends on the reference: a notch delays and shapes the feed-forward
/// too. A filter that allows no more ki than none is left out. Gains and filters of `config` have no part in
/// it.
std::vector<LoopConfig> designs(const LoopConfig& config, const PlantUncertainty& uncertainty,
                                const SensitivityRule& rule);

struct JudgedLoop {
  Margins margins;  ///< for the plant of the configuration
  Margins worst;    ///< each has its worst value at the corners
};
JudgedLoop judge(const LoopConfig& config, const PlantUncertainty& uncertainty);

}  // namespace hystcan::controller
