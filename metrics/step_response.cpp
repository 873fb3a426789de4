#include "metrics/step_response.h"

#include <algorithm>
#include <cmath>

namespace hystcan::metrics {
namespace {

constexpr std::size_t least_rest = 10;  // cycles, of a jump in a record

/// The first cycle in which the reference is no longer what it is in this one.
std::size_t end_of_rest(std::span<const double> reference_um, std::size_t cycle) {
  const auto rest = reference_um.subspan(cycle);
  const auto end = std::ranges::find_if(rest, [&](double value) { return value != rest.front(); });
  return cycle + static_cast<std::size_t>(end - rest.begin());
}

Step begin_step(double from_um, double to_um, double time_s, double tolerance_um) {
  return {.from_um = from_um,
          .to_um = to_um,
          .band_um = tolerance_um > 0.0 ? tolerance_um : 0.01 * std::abs(to_um - from_um),
          .begin_s = time_s,
          .last_s = time_s,
          .settled_s = {},
          .at_tenth_s = {},
          .at_nine_tenths_s = {}};
}

}  // namespace

void Step::add(double time_s, double position_um) {
  ++cycles;
  last_s = time_s;
  const double share = (position_um - from_um) / (to_um - from_um);
  if (!at_tenth_s && share >= 0.1) at_tenth_s = time_s;
  if (!at_nine_tenths_s && share >= 0.9) at_nine_tenths_s = time_s;
  overshoot_um = std::max(overshoot_um, (to_um > from_um ? 1.0 : -1.0) * (position_um - to_um));
  if (!(std::abs(to_um - position_um) <= band_um))
    settled_s.reset();
  else if (!settled_s)
    settled_s = time_s;
}

std::optional<double> Step::settling_s() const {
  return settled_s ? std::optional(*settled_s - begin_s) : std::nullopt;
}

std::optional<double> Step::rise_s() const {
  return at_tenth_s && at_nine_tenths_s ? std::optional(*at_nine_tenths_s - *at_tenth_s) : std::nullopt;
}

double Step::overshoot() const { return overshoot_um / std::abs(to_um - from_um); }

void StepResponse::add(double time_s, double reference_um, double position_um, bool at_rest) {
  const bool leaves_level = !at_rest || (level_um_ && *level_um_ != reference_um);
  if (step_ && leaves_level) {
    count(*step_, finished_);
    step_.reset();
  }
  if (!at_rest) return;
  if (level_um_ && *level_um_ != reference_um)
    step_ = begin_step(*level_um_, reference_um, time_s, tolerance_um_);
  level_um_ = reference_um;
  if (step_) step_->add(time_s, position_um);
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
  if (const auto settling_s = step.settling_s())
    result.settling_s = std::max(result.settling_s, *settling_s);
  else
    ++result.not_settled;
  result.overshoot = std::max(result.overshoot, step.overshoot());
}

std::optional<Step> step_at(const Cycles& cycles, std::size_t cycle, double tolerance_um) {
  const std::span<const double> reference_um = cycles.reference_um;
  if (cycle == 0 || cycle >= reference_um.size()) return std::nullopt;
  const bool jumps = std::abs(reference_um[cycle] - reference_um[cycle - 1]) > 0.0;
  const std::size_t end = end_of_rest(reference_um, cycle);
  if (!jumps || end < cycle + least_rest) return std::nullopt;
  Step step = begin_step(reference_um[cycle - 1], reference_um[cycle], cycles.time_s[cycle], tolerance_um);
  for (std::size_t i = cycle; i < end; ++i)
    if (std::isfinite(cycles.position_um[i])) step.add(cycles.time_s[i], cycles.position_um[i]);
  step.cycles = end - cycle;
  step.last_s = cycles.time_s[end - 1];
  return step;
}

std::optional<Step> largest_step(const Cycles& cycles, double tolerance_um, std::size_t& begin) {
  const std::span<const double> reference_um = cycles.reference_um;
  if (reference_um.size() <= least_rest) return std::nullopt;
  const auto [low, high] = std::ranges::minmax(reference_um);
  begin = 0;
  double largest_um = 0.5 * (high - low);
  for (std::size_t i = 1; i < reference_um.size(); ++i) {
    const double change_um = std::abs(reference_um[i] - reference_um[i - 1]);
    if (!(change_um > 0.0) || change_um < largest_um || end_of_rest(reference_um, i) < i + least_rest)
      continue;
    begin = i;
    largest_um = change_um;
  }
  return step_at(cycles, begin, tolerance_um);
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

}  // namespace hystcan::metrics
