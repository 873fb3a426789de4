#include "identification/dynamics/tuning.h"

#include <algorithm>

namespace hystcan::identification {
namespace {

Margins worse_of(const Margins& a, const Margins& b) {
  return {.stable = a.stable && b.stable,
          .phase_margin_deg = std::min(a.phase_margin_deg, b.phase_margin_deg),
          .gain_margin = std::min(a.gain_margin, b.gain_margin),
          .peak_beyond_180 = std::max(a.peak_beyond_180, b.peak_beyond_180),
          .peak_sensitivity = std::max(a.peak_sensitivity, b.peak_sensitivity),
          .crossover_Hz = std::min(a.crossover_Hz, b.crossover_Hz),
          .bandwidth_Hz = std::min(a.bandwidth_Hz, b.bandwidth_Hz)};
}

}  // namespace

Tuning judge(const PiGains& gains, const SecondOrderFit& fit, double cycle_s) {
  Tuning tuning{.gains = gains,
                .margins = SampledLoop(fit.mode(), fit.delay_s.value, cycle_s).margins(gains),
                .worst = {}};
  tuning.worst = tuning.margins;
  for (const double frequency_Hz : {fit.natural_frequency_Hz.lo, fit.natural_frequency_Hz.hi})
    for (const double damping_ratio : {fit.damping_ratio.lo, fit.damping_ratio.hi})
      for (const double delay_s : {fit.delay_s.lo, fit.delay_s.hi}) {
        const SampledLoop corner({frequency_Hz, damping_ratio}, delay_s, cycle_s);
        tuning.worst = worse_of(tuning.worst, corner.margins(gains));
      }
  return tuning;
}

Tuning tune(const SecondOrderFit& fit, double cycle_s, const PiRule& rule) {
  return judge(SampledLoop(fit.mode(), fit.delay_s.value, cycle_s).suggest(rule), fit, cycle_s);
}

}  // namespace hystcan::identification
