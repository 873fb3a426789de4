#include "controller/control/ramp_check.h"

#include <algorithm>
#include <cmath>

namespace hystcan::controller {
namespace {

constexpr double mean_cycles = 2.0, rest_cycles = 200.0;
constexpr double floor_share = 0.003;  // share of the stroke that is added to the allowed error
constexpr double backwards_share = 0.25;
// A window is a part of the ramp in which model and sensor must move by similar amounts. The first window
// begins when the drive has travelled by delayed_share of its range since a turn. A window is judged after
// window_share from its beginning, and the next window begins after next_window_share.
constexpr double delayed_share = 0.08, window_share = 0.14, next_window_share = 0.16;
// Minimum number of cycles from a turn of the ramp until a window begins, and from the beginning of a window
// until it is judged. If a fast ramp travels far enough in fewer cycles, the check waits for this number.
constexpr unsigned least_cycles = 6;
constexpr unsigned contradictions_to_trip = 3;

/// Returns the weight of the present sample in a running mean over `time_s`.
double weight(const AxisInput& input, double time_s) { return input.dt_s / (input.dt_s + time_s); }

}  // namespace

void RampCheck::see(const AxisInput& input) {
  if (!input.position_um) return;
  const double own_um = *input.position_um - input.coupled_um;
  const double last_um = seen_um_.value_or(own_um);
  seen_um_ = last_um + (own_um - last_um) * weight(input, mean_cycles * input.cycle_s);
  const double forgotten = weight(input, std::max(rest_cycles * input.cycle_s, config_.decay_s));
  const double middle_um = 0.5 * (rest_um_.lo + rest_um_.hi);
  rest_um_.lo += (middle_um - rest_um_.lo) * forgotten;
  rest_um_.hi += (middle_um - rest_um_.hi) * forgotten;
}

void RampCheck::widen_rest(const AxisInput& input, const std::optional<double>& last_um) {
  const double now_um = *seen_um_;
  if (!last_um) rest_um_ = {now_um, now_um};
  const double swing_um = std::abs(now_um - last_um.value_or(now_um)) / (input.dt_s * config_.mode_rad_per_s);
  rest_um_ = {std::min(rest_um_.lo, now_um - swing_um), std::max(rest_um_.hi, now_um + swing_um)};
}

RampCheck::Anchor RampCheck::here(const Course& course, double drive) const {
  return {.model = course.mark(), .seen_um = *seen_um_, .drive = drive};
}

void RampCheck::rest(const Course& course, double drive, const AxisInput& input) {
  const std::optional<double> last_um = seen_um_;
  see(input);
  model_um_ = course.position_um();
  if (!seen_um_) return;
  widen_rest(input, last_um);
  turn_ = here(course, drive);
}

bool RampCheck::step(const Course& course, double drive, const AxisInput& input) {
  const double moved_um = course.position_um() - model_um_;
  if (!seen_um_ || (direction_ == 0.0 && moved_um == 0.0)) {
    rest(course, drive, input);
    return true;
  }
  see(input);
  model_um_ = course.position_um();
  if (moved_um * direction_ < 0.0) {
    turn_ = here(course, drive);
    window_.reset();
    contradictions_ = 0;
  }
  if (moved_um != 0.0) direction_ = std::copysign(1.0, moved_um);
  ++turn_.cycles;
  if (window_) ++window_->cycles;
  if (!window_ && is_beyond(turn_, delayed_share, drive)) window_ = here(course, drive);
  if (!input.position_um) return true;
  const bool agrees = agrees_in_direction(course) &&
                      (!window_ || !is_beyond(*window_, window_share, drive) || agrees_in_size(course));
  contradictions_ = agrees ? 0 : contradictions_ + 1;
  if (agrees && window_ && is_beyond(*window_, next_window_share, drive)) window_ = here(course, drive);
  return contradictions_ < contradictions_to_trip;
}

bool RampCheck::is_beyond(const Anchor& anchor, double share, double drive) const {
  return anchor.cycles >= least_cycles && std::abs(drive - anchor.drive) >= share * config_.drive_range;
}

bool RampCheck::agrees_in_direction(const Course& course) const {
  const double least_um = moved_um(course, turn_).lo;
  const double bound_um =
      least_um > 0.0 ? -backwards_share * least_um : least_um / (1.0 - config_.slope_shortfall);
  return direction_ * (*seen_um_ - turn_.seen_um) >= bound_um - error_um();
}

bool RampCheck::agrees_in_size(const Course& course) const {
  const double share = 1.0 - config_.slope_shortfall;
  const auto [least_um, most_um] = moved_um(course, *window_);
  const double seen_um = direction_ * (*seen_um_ - window_->seen_um);
  return seen_um >= (least_um > 0.0 ? share * least_um : least_um / share) - error_um() &&
         seen_um <= most_um / share + error_um();
}

/// Returns the smallest and the largest possible motion of the model since the anchor, the moment when the
/// comparison began. A motion in the present direction is positive.
model::Interval RampCheck::moved_um(const Course& course, const Anchor& anchor) const {
  const model::Interval moved = course.moved_um(anchor.model);
  return direction_ > 0.0 ? moved : model::Interval{-moved.hi, -moved.lo};
}

double RampCheck::error_um() const {
  return floor_share * config_.stroke_um + config_.ramp_um_per_s / config_.mode_rad_per_s + rest_um_.span();
}

}  // namespace hystcan::controller
