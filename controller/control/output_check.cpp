#include "controller/control/output_check.h"

#include <algorithm>

namespace hystcan::controller {

void OutputCheck::restart(double drive) {
  spans_.fill({drive, drive});
  span_s_ = differs_for_s_ = 0.0;
}

void OutputCheck::step(double drive, const AxisInput& input) {
  const double span_s = std::max(0.05, 5.0 * input.cycle_s);
  span_s_ += input.dt_s;
  if (span_s_ >= span_s) {
    std::shift_right(spans_.begin(), spans_.end(), 1);
    spans_.front() = {drive, drive};
    span_s_ = 0.0;
  }
  spans_.front().least = std::min(spans_.front().least, drive);
  spans_.front().most = std::max(spans_.front().most, drive);
  const NodeHealth& health = input.health;
  if (!health.output_reported || health.status_age_s > span_s) return;
  const double least = std::ranges::min(spans_, {}, &Drives::least).least - margin_;
  const double most = std::ranges::max(spans_, {}, &Drives::most).most + margin_;
  // With NaN the comparison is false: the output differs.
  const bool agrees = health.amplifier_output >= least && health.amplifier_output <= most;
  differs_for_s_ = agrees ? 0.0 : differs_for_s_ + input.dt_s;
}

}  // namespace hystcan::controller
