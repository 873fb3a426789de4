#include "controller/control/output_check.h"

#include <algorithm>
#include <cmath>

namespace hystcan::controller {
namespace {

constexpr double margin_share = 0.05;
constexpr double late_cycles = 4.0, late_lags = 5.0;

}  // namespace

void OutputCheck::restart(double drive) {
  spans_.fill({drive, drive});
  span_s_ = status_age_s_ = differs_for_s_ = 0.0;
  agrees_ = true;
}

void OutputCheck::step(double drive, double slew_per_s, const AxisInput& input) {
  const double span_s = std::max({0.05, 5.0 * input.cycle_s, late_lags * lag_s_});
  span_s_ += input.dt_s;
  if (span_s_ >= span_s) {
    std::shift_right(spans_.begin(), spans_.end(), 1);
    spans_.front() = {drive, drive};
    span_s_ = 0.0;
  }
  spans_.front().lo = std::min(spans_.front().lo, drive);
  spans_.front().hi = std::max(spans_.front().hi, drive);
  const NodeHealth& health = input.health;
  const bool is_new = health.status_age_s < status_age_s_ + 0.5 * input.dt_s;
  status_age_s_ = health.status_age_s;
  if (!health.output_reported || status_age_s_ > span_s)
    agrees_ = true;
  else if (is_new)
    agrees_ = agrees(drive, slew_per_s, input);
  differs_for_s_ = agrees_ ? 0.0 : differs_for_s_ + input.dt_s;
}

bool OutputCheck::agrees(double drive, double slew_per_s, const AxisInput& input) const {
  const double output = input.health.amplifier_output;
  const double late_s = status_age_s_ + late_cycles * input.cycle_s + late_lags * lag_s_;
  const double margin = margin_share * drive_range_;
  // If the output is NaN, the comparisons are false: the output counts as different.
  return std::abs(output - drive) <= margin + slew_per_s * late_s &&
         output >= std::ranges::min(spans_, {}, &model::Interval::lo).lo - margin &&
         output <= std::ranges::max(spans_, {}, &model::Interval::hi).hi + margin;
}

}  // namespace hystcan::controller
