#include "controller/control/step_response.h"

#include <algorithm>
#include <cmath>

namespace hystcan::controller {

void StepResponse::add(double time_s, double reference_um, double position_um, bool at_rest) {
  const bool leaves_level = !at_rest || (level_um_ && *level_um_ != reference_um);
  if (step_ && leaves_level) {
    count(*step_, finished_);
    step_.reset();
  }
  if (!at_rest) return;
  if (level_um_ && *level_um_ != reference_um) {
    const double height_um = std::abs(reference_um - *level_um_);
    step_ = Step{.from_um = *level_um_,
                 .to_um = reference_um,
                 .band_um = band_um_ > 0.0 ? band_um_ : 0.01 * height_um,
                 .begin_s = time_s,
                 .settled_s = time_s};
  }
  level_um_ = reference_um;
  if (!step_) return;
  const double direction = step_->to_um > step_->from_um ? 1.0 : -1.0;
  step_->overshoot_um = std::max(step_->overshoot_um, direction * (position_um - reference_um));
  const bool was_inside = step_->is_inside;
  step_->is_inside = std::abs(reference_um - position_um) <= step_->band_um;
  if (!was_inside) step_->settled_s = time_s;
}

void StepResponse::leave() {
  if (step_) count(*step_, finished_);
  step_.reset();
  level_um_.reset();
}

StepResponse::Result StepResponse::result() const {
  Result result = finished_;
  if (step_) count(*step_, result);
  return result;
}

void StepResponse::count(const Step& step, Result& result) {
  ++result.steps;
  if (step.is_inside)
    result.settling_s = std::max(result.settling_s, step.settled_s - step.begin_s);
  else
    ++result.not_settled;
  result.overshoot = std::max(result.overshoot, step.overshoot_um / std::abs(step.to_um - step.from_um));
}

void HoldNoise::add(double reference_um, double position_um, double band_um, bool at_rest) {
  if (!at_rest || reference_um != level_um_) leave();
  if (!at_rest) return;
  level_um_ = reference_um;
  if (band_um > 0.0 && std::abs(reference_um - position_um) > band_um) {
    samples_ = 0;
    mean_um_ = sum_of_squares_ = 0.0;
    return;
  }
  ++samples_;  // Welford's recursion
  const double before_um = position_um - mean_um_;
  mean_um_ += before_um / static_cast<double>(samples_);
  sum_of_squares_ += before_um * (position_um - mean_um_);
}

void HoldNoise::leave() {
  pooled_ += sum_of_squares_;
  pooled_samples_ += samples_;
  samples_ = 0;
  mean_um_ = sum_of_squares_ = 0.0;
}

double HoldNoise::rms_um() const {
  return samples() == 0 ? 0.0 : std::sqrt((pooled_ + sum_of_squares_) / static_cast<double>(samples()));
}

}  // namespace hystcan::controller
