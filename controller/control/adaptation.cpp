#include "controller/control/adaptation.h"

#include <algorithm>

namespace hystcan::controller {

ModelCorrection Adaptation::step(const Config& config, const ModelCorrection& before,
                                 const model::Interval& range_um, double modelled_um, double integral_um,
                                 double dt_s) {
  const double middle = 0.5 * (range_um.lo + range_um.hi), half = 0.5 * range_um.span();
  const double phi = (modelled_um - middle) / half;
  const double step_um = -integral_um * std::min(dt_s / config.time_constant_s, 1.0) / (1.0 + phi * phi);
  const double gain_step = step_um * phi / half;
  const double offset_step = step_um - gain_step * middle;
  return within_bounds(config, {.gain = before.gain + gain_step, .offset_um = before.offset_um + offset_step},
                       range_um);
}

ModelCorrection Adaptation::within_bounds(const Config& config, const ModelCorrection& correction,
                                          const model::Interval& range_um) {
  const double middle = 0.5 * (range_um.lo + range_um.hi);
  const double gain = std::clamp(correction.gain, 1.0 - config.gain_max, 1.0 + config.gain_max);
  const double at_middle_um = std::clamp(correction.offset_um + (correction.gain - 1.0) * middle,
                                         -config.offset_max_um, config.offset_max_um);
  return {.gain = gain, .offset_um = at_middle_um - (gain - 1.0) * middle};
}

}  // namespace hystcan::controller
