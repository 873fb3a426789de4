#include "controller/control/plausibility.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace hystcan::controller {
namespace {

constexpr double margin_share = 0.05;
constexpr double late_cycles = 4.0, late_lags = 5.0;

/// Reversals that it remembers; deeper ones are merged.
constexpr std::size_t capacity = 64;

constexpr double mean_cycles = 2.0, rest_cycles = 200.0;
constexpr double floor_share = 0.003;  // of e
constexpr double backwards_share = 0.25;
constexpr double delayed_share = 0.08, window_share = 0.14, next_window_share = 0.16;  // of the drive's range
constexpr unsigned least_cycles = 6;  // in these shares: of a ramp that is fast for its rate
constexpr unsigned contradictions_to_trip = 3;

/// Share by which a mean over this time comes closer to a sample.
double weight(const AxisInput& input, double time_s) { return input.dt_s / (input.dt_s + time_s); }

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
  // With NaN the comparisons are false: the output differs.
  return std::abs(output - drive) <= margin + slew_per_s * late_s &&
         output >= std::ranges::min(spans_, {}, &model::Interval::lo).lo - margin &&
         output <= std::ranges::max(spans_, {}, &model::Interval::hi).hi + margin;
}

Course::Course(const model::HysteresisParameters& parameters, const Delays& delays)
    : model_(parameters),
      delays_(delays),
      at_thresholds_{model_.at_upper_threshold(capacity), model_.virgin(model_.input_range().lo, capacity)},
      memories_(at_thresholds_) {}

void Course::restart(double drive) {
  memories_ = at_thresholds_;
  Positions now{};
  for (std::size_t i = 0; i < memories_.size(); ++i)
    now[i] = mark_[i] = mark_[2 + i] = model_.advance(memories_[i], drive).value;
  under_way_ = {};
  under_way_.past.fill(now);
}

void Course::step(double drive, double dt_s, double cycle_s) {
  if (cycle_s != cycle_s_) plan(cycle_s);
  Positions now{};
  for (std::size_t i = 0; i < memories_.size(); ++i)
    now[i] = mark_[i] = model_.advance(memories_[i], drive).value;
  const Positions late = delayed(now, dt_s);
  const double share = dt_s / (dt_s + lag_s_);
  for (std::size_t i = 0; i < late.size(); ++i) mark_[2 + i] += (late[i] - mark_[2 + i]) * share;
}

/// The pure delays to a cycle, or to a 31st of them where that is more.
void Course::plan(double cycle_s) {
  cycle_s_ = cycle_s;
  const double pure_s = delays_.pure_s();
  lag_s_ = delays_.to_sample_s(cycle_s) - pure_s + 2.0 * cycle_s;
  apart_s_ = std::max(cycle_s, pure_s / static_cast<double>(under_way_.past.size() - 1));
  ago_ = static_cast<std::size_t>(std::round(pure_s / apart_s_));
}

/// The positions of the pure delays ago.
Course::Positions Course::delayed(const Positions& now, double dt_s) {
  auto& [past, newest, since_newest_s] = under_way_;
  for (since_newest_s += dt_s; since_newest_s >= 0.5 * apart_s_; since_newest_s -= apart_s_) {
    newest = (newest + 1) % past.size();
    past[newest] = now;
  }
  return past[(newest + past.size() - ago_) % past.size()];
}

model::Interval Course::moved_um(const Mark& since) const {
  Mark moved{};
  std::ranges::transform(mark_, since, moved.begin(), std::minus{});
  const auto [least, most] = std::ranges::minmax(moved);
  return {least, most};
}

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
  const double bound_um = least_um > 0.0 ? -backwards_share * least_um : least_um / (1.0 - config_.doubt);
  return direction_ * (*seen_um_ - turn_.seen_um) >= bound_um - error_um();
}

bool RampCheck::agrees_in_size(const Course& course) const {
  const double share = 1.0 - config_.doubt;
  const auto [least_um, most_um] = moved_um(course, *window_);
  const double seen_um = direction_ * (*seen_um_ - window_->seen_um);
  return seen_um >= (least_um > 0.0 ? share * least_um : least_um / share) - error_um() &&
         seen_um <= most_um / share + error_um();
}

/// In the present direction.
model::Interval RampCheck::moved_um(const Course& course, const Anchor& anchor) const {
  const model::Interval moved = course.moved_um(anchor.model);
  return direction_ > 0.0 ? moved : model::Interval{-moved.hi, -moved.lo};
}

double RampCheck::error_um() const {
  return floor_share * config_.stroke_um + config_.ramp_um_per_s / config_.mode_rad_per_s + rest_um_.span();
}

}  // namespace hystcan::controller
