#include "controller/control/oscillation.h"

#include <algorithm>
#include <cmath>

namespace hystcan::controller {
namespace {

// The error turns only if it moves back by more than this share of `amplitude_um`. A smaller motion is noise.
constexpr double smallest_turn = 1.0 / 32.0;
// The error turns only if it also moves back by more than this share of the larger swing of the previous two
// half-periods. A smaller motion is the ringing of the stage's mode while the drive rests.
constexpr double smallest_share = 1.0 / 8.0;
constexpr std::size_t few = 4, many = 8;  // numbers of compared pairs of half-periods
// An oscillation grows fast if, among the last `few` pairs of half-periods, the newest swing is more than
// fast_growth times the oldest swing. It grows slowly if, among the last `many` pairs of half-periods, this
// factor is more than slow_growth.
constexpr double fast_growth = 4.0;
constexpr double slow_growth = 1.5;
// An oscillation grows only if its second newest pair of half-periods has a swing (peak to peak) of at least
// this share of 2 `amplitude_um`. So a single knock on the stage does not count as growth: before the knock,
// the swing is smaller.
constexpr double before_growth = 1.0 / 8.0;
// An oscillation stays large if the largest swing of the newest four pairs of half-periods is at least this
// share of the largest swing of the four pairs before.
constexpr double no_decay = 0.95;
// Maximum ratio of the longest to the shortest half-period. Half-periods in which the error rises are
// compared with each other, and half-periods in which the error falls are compared with each other.
constexpr std::size_t unevenness = 4;
// Maximum ratio of the longest to the shortest half-period of an oscillation, if half-periods with a rising
// error and half-periods with a falling error are compared with each other. If the ratio is larger, the
// motion of the error is not an oscillation.
constexpr std::size_t longer_way = 16;
constexpr std::size_t short_spike = 4;  // maximum length of a spike, in cycles
// A step of the reference makes the mode ring. The sum of |second differences| of the reference is twice the
// height of the step. If the swing is less than this factor times the sum, a step may be the cause of the
// swing, and the loop is not judged.
constexpr double step_response = 1.5;
// A mode with a damping ratio of 0.017 amplifies the second differences of the reference by this factor. If
// the second differences of the error are less than this factor times those of the reference, the reference
// may be the cause of the error.
constexpr double amplification = 30.0;

}  // namespace

void Oscillation::Bend::add(double value_um) {
  const double step_um = value_um - last_um;
  sum_um += std::abs(step_um - last_step_um);
  last_step_um = step_um;
  last_um = value_um;
}

bool Oscillation::step(double reference_um, double position_um) {
  const double error_um = reference_um - position_um;
  reference_.add(reference_um);
  error_.add(error_um);
  if (samples_ < 3) {
    ++samples_;
    reference_.sum_um = error_.sum_um = 0.0;
    turn_um_ = extreme_um_ = error_um;
    return false;
  }
  return turns(error_um) && (grows(few) || grows(many) || stays());
}

/// Takes the error of this cycle. Returns true if this error ends a half-period of the oscillation.
bool Oscillation::turns(double error_um) {
  const double further = rises_ ? error_um - extreme_um_ : extreme_um_ - error_um;
  if (further >= 0.0) extreme_um_ = error_um;
  const double swing_um = closed_ < 2 ? 0.0 : pair_um(0);
  const bool has_turned = further < -std::max(smallest_turn * amplitude_um_, smallest_share * swing_um);
  if (has_turned) close(error_um);
  if ((error_um > middle_um_) == rises_) ++cycles_;
  return has_turned;
}

void Oscillation::close(double error_um) {
  newest_ = (newest_ + 1) % kept;
  past_[newest_] = {cycles_, std::abs(extreme_um_ - turn_um_), reference_.sum_um, error_.sum_um};
  closed_ = std::min(closed_ + 1, kept);
  middle_um_ = 0.5 * (turn_um_ + extreme_um_);
  turn_um_ = extreme_um_;
  extreme_um_ = error_um;
  rises_ = !rises_;
  cycles_ = 0;
  reference_.sum_um = error_.sum_um = 0.0;
}

double Oscillation::pair_um(std::size_t j) const {
  return std::max(ago(2 * j).swing_um, ago(2 * j + 1).swing_um);
}

bool Oscillation::grows(std::size_t pairs) const {
  if (closed_ < 2 * pairs) return false;
  if (pair_um(0) < 2.0 * amplitude_um_) return false;
  if (pair_um(1) < 2.0 * amplitude_um_ * before_growth) return false;
  for (std::size_t j = 0; j + 1 < pairs; ++j)
    if (!(pair_um(j) > pair_um(j + 1))) return false;
  return pair_um(0) > (pairs == few ? fast_growth : slow_growth) * pair_um(pairs - 1) && is_even(2 * pairs) &&
         !is_forced(2 * pairs);
}

bool Oscillation::stays() const {
  if (closed_ < kept) return false;
  double recent_um = 0.0, former_um = 0.0;
  for (std::size_t j = 0; j < kept / 2; ++j) {
    const double swing_um = pair_um(j);
    if (swing_um < 2.0 * amplitude_um_) return false;
    double& largest_um = j < kept / 4 ? recent_um : former_um;
    largest_um = std::max(largest_um, swing_um);
  }
  return recent_um >= no_decay * former_um && is_even(kept) && !is_forced(kept);
}

bool Oscillation::is_even(std::size_t half_periods) const {
  std::array<std::size_t, 2> shortest{ago(0).cycles, ago(1).cycles}, longest = shortest;
  for (std::size_t k = 2; k < half_periods; ++k) {
    shortest[k % 2] = std::min(shortest[k % 2], ago(k).cycles);
    longest[k % 2] = std::max(longest[k % 2], ago(k).cycles);
  }
  const std::size_t fewest = std::min(shortest[0], shortest[1]);
  const std::size_t most = std::max(longest[0], longest[1]);
  if (fewest < short_spike) return most <= unevenness * std::max<std::size_t>(fewest, 1) + 1;
  return longest[0] <= unevenness * shortest[0] && longest[1] <= unevenness * shortest[1] &&
         most <= longer_way * fewest;
}

double Oscillation::error_bend_um(std::size_t pair) const {
  return ago(2 * pair).error_bend_um + ago(2 * pair + 1).error_bend_um;
}

double Oscillation::reference_bend_um(std::size_t pair) const {
  return ago(2 * pair).reference_bend_um + ago(2 * pair + 1).reference_bend_um;
}

bool Oscillation::is_forced(std::size_t half_periods) const {
  const std::size_t pairs = half_periods / 2;
  std::size_t forced = 0;
  double bends_um = 0.0;
  for (std::size_t j = 0; j < pairs; ++j) {
    if (error_bend_um(0) < amplification * reference_bend_um(j)) ++forced;
    bends_um += reference_bend_um(j);
  }
  return 2 * forced > pairs || pair_um(0) < step_response * bends_um;
}

}  // namespace hystcan::controller
