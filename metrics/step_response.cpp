#include "metrics/step_response.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hystcan::metrics {
namespace {

constexpr std::size_t least_rest = 10;  // a reference that is constant for fewer cycles is moving

/// A move of the reference from one resting level to the next one, in a record.
struct Move {
  double from_um = 0.0;
  std::size_t left = 0;            ///< first cycle after the rest at the previous level
  std::size_t begin = 0, end = 0;  ///< first cycle at the new level, and the cycle after the last one
};

/// Finds all moves of the reference from one resting level to the next one. Calls `visit` with each move.
template <class Visit>
void for_each_move(std::span<const double> reference_um, Visit visit) {
  double level_um = std::numeric_limits<double>::quiet_NaN();
  std::size_t left = 0;
  for (std::size_t begin = 0, end = 0; begin < reference_um.size(); begin = end) {
    const double here_um = reference_um[begin];
    for (end = begin + 1; end < reference_um.size() && reference_um[end] == here_um;) ++end;
    if (!std::isnan(here_um) && end - begin < least_rest && begin > 0) continue;
    if (std::abs(here_um - level_um) > 0.0)
      visit(Move{.from_um = level_um, .left = left, .begin = begin, .end = end});
    level_um = here_um;
    left = end;
  }
}

Step begin_step(double from_um, double to_um, double time_s, double tolerance_um) {
  return {.from_um = from_um,
          .to_um = to_um,
          .band_um = tolerance_um > 0.0 ? tolerance_um : 0.01 * std::abs(to_um - from_um),
          .begin_s = time_s,
          .last_s = time_s};
}

Step response_to(const Move& move, const Cycles& cycles, double tolerance_um) {
  Step step =
      begin_step(move.from_um, cycles.reference_um[move.begin], cycles.time_s[move.begin], tolerance_um);
  for (std::size_t i = move.begin; i < move.end; ++i)
    if (std::isfinite(cycles.position_um[i])) step.add(cycles.time_s[i], cycles.position_um[i]);
  step.cycles = move.end - move.begin;
  step.last_s = cycles.time_s[move.end - 1];
  return step;
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
  std::optional<Step> step;
  for_each_move(cycles.reference_um, [&](const Move& move) {
    if (move.left <= cycle && cycle <= move.begin) step = response_to(move, cycles, tolerance_um);
  });
  return step;
}

std::optional<Step> largest_step(const Cycles& cycles, double tolerance_um, std::size_t& begin) {
  std::optional<Move> largest;
  double largest_um = 0.0;
  for_each_move(cycles.reference_um, [&](const Move& move) {
    const double moved_um = std::abs(cycles.reference_um[move.begin] - move.from_um);
    if (moved_um <= largest_um) return;
    largest = move;
    largest_um = moved_um;
  });
  if (!largest) return std::nullopt;
  begin = largest->begin;
  return response_to(*largest, cycles, tolerance_um);
}

void HoldNoise::add(double reference_um, double position_um, double band_um, bool at_rest) {
  if (!at_rest || reference_um != level_um_) leave();
  if (!at_rest) return;
  level_um_ = reference_um;
  ++at_rest_;
  if (band_um > 0.0 && std::abs(reference_um - position_um) > band_um) {
    samples_ = 0;
    mean_um_ = sum_of_squares_ = 0.0;
    return;
  }
  ++samples_;  // Welford's method updates the mean and the sum of squares with each sample
  const double before_um = position_um - mean_um_;
  mean_um_ += before_um / static_cast<double>(samples_);
  sum_of_squares_ += before_um * (position_um - mean_um_);
}

void HoldNoise::leave() {
  if (counts()) {
    pooled_ += sum_of_squares_;
    pooled_samples_ += samples_;
  }
  samples_ = at_rest_ = 0;
  mean_um_ = sum_of_squares_ = 0.0;
}

double HoldNoise::rms_um() const {
  if (samples() == 0) return 0.0;
  return std::sqrt((pooled_ + (counts() ? sum_of_squares_ : 0.0)) / static_cast<double>(samples()));
}

}  // namespace hystcan::metrics
