#include "model/hysteresis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "model/fingerprint.h"
#include "model/memory_model_impl.h"
#include "model/validity.h"

namespace hystcan::model {

inline double ExponentialConvergence::Convergence::phi(double d) const {
  return steep ? (1.0 - std::exp(-k * d)) * reciprocal : precise_phi(d);
}

double ExponentialConvergence::Convergence::precise_phi(double d) const {
  return k == 0.0 ? d : -std::expm1(-k * d) * reciprocal;
}

inline double ExponentialConvergence::Convergence::decay(double d) const { return std::exp(-k * d); }

ExponentialConvergence::ExponentialConvergence(HysteresisParameters parameters)
    : parameters_(std::move(parameters)) {
  ascending_ = convergence(Direction::ascending);
  descending_ = convergence(Direction::descending);
  const Interval& range = input_range();
  const double reach = parameters_.upper_point().level - parameters_.lower_point().level;
  slope_tolerance_ = 1e-9 * reach / range.span();
}

inline double ExponentialConvergence::between(double a, double b) const {
  return std::abs(parameters_.place(a) - parameters_.place(b));
}

std::uint64_t ExponentialConvergence::fingerprint() const {
  Fingerprint sum;
  sum.add(kind());
  add_curves(sum, parameters_);
  sum.add(parameters_.k_ascending);
  sum.add(parameters_.k_descending);
  return sum.value();
}

ExponentialConvergence::Convergence ExponentialConvergence::convergence(Direction direction) const {
  const double k = parameters_.k(direction);
  Convergence pace;
  const double k_span = std::abs(k) * between(input_range().lo, input_range().hi);
  if (k_span > 1e-17) {
    pace.k = k;
    pace.reciprocal = 1.0 / k;
    pace.steep = k_span > 1.0;
    pace.fading_third = k * k * (k < 0.0 ? std::exp(k_span) : 1.0);
  }
  pace.curve_third = parameters_.input_map ? std::numeric_limits<double>::infinity()
                                           : parameters_.curve(direction).third_derivative_bound();
  const auto bend = [&](double v) {
    const Jet curve = parameters_.curve(direction).jet(v);
    if (!parameters_.input_map) return sign(direction) * curve.curvature + k * curve.slope;
    const Jet map = parameters_.input_map->jet(v);
    return sign(direction) * (curve.curvature * map.slope - curve.slope * map.curvature) /
               (map.slope * map.slope) +
           k * curve.slope;
  };
  constexpr std::size_t points = 400;
  std::vector<double> grid = grid_of(input_range(), parameters_.curve(direction).knots(), points);
  if (direction == Direction::descending) std::ranges::reverse(grid);
  for (std::size_t i = 0; i <= points; ++i) {
    if (bend(grid[i]) >= 0.0) continue;
    pace.lowest_at_start = false;
    if (i + 1 >= points || bend(grid[i + 1]) < 0.0) continue;
    double flatter = grid[i], steeper = grid[i + 1];
    for (int j = 0; j < 40; ++j) {
      const double middle = flatter + (steeper - flatter) / 2.0;
      (bend(middle) < 0.0 ? flatter : steeper) = middle;
    }
    pace.flattest.push_back(flatter);
  }
  return pace;
}

inline const ExponentialConvergence::Convergence& ExponentialConvergence::pace(Direction direction) const {
  return direction == Direction::ascending ? ascending_ : descending_;
}

inline double ExponentialConvergence::value(const Branch& branch, Direction direction, double input) const {
  const double d = between(input, branch.start_input);
  // phi() is called first: it calls exp(), and other values need not be saved in memory during this call.
  const double phi = pace(direction).phi(d);
  return parameters_.curve(direction).value(input) + (branch.offset - branch.coefficient * phi);
}

inline Jet ExponentialConvergence::jet(const Branch& branch, Direction direction, double input) const {
  const double d = between(input, branch.start_input);
  const Convergence& convergence = pace(direction);
  const double decay = convergence.decay(d);
  const double phi = convergence.steep ? (1.0 - decay) * convergence.reciprocal : convergence.phi(d);
  const double fading = branch.coefficient * decay;
  const Jet reference = parameters_.curve(direction).jet(input);
  const double value = reference.value + (branch.offset - branch.coefficient * phi);
  if (!parameters_.input_map)
    return {value, reference.slope - sign(direction) * fading, reference.curvature + convergence.k * fading};
  const Jet map = parameters_.input_map->jet(input);
  return {value, reference.slope - sign(direction) * fading * map.slope,
          reference.curvature +
              fading * (convergence.k * map.slope * map.slope - sign(direction) * map.curvature)};
}

inline double ExponentialConvergence::slope(const Branch& branch, Direction direction, double input) const {
  const double d = between(input, branch.start_input);
  return parameters_.curve(direction).slope(input) -
         sign(direction) * branch.coefficient * pace(direction).decay(d) * parameters_.stretch(input);
}

// Returns true if the branch increases between its start and `target`. The slope of the branch is
//
//   f_0' - sigma S e^{-k d} h'
//
// with the reference curve f_0, the branch's coefficient S, sigma = +1 for a rising and -1 for a falling
// branch, the convergence rate k, the distance d from the start, and the input map h. If the slope is
// negative anywhere, it is negative at the start, at the target, or at an input in `flattest`. Only these
// inputs are therefore checked.
bool ExponentialConvergence::is_increasing(const Branch& branch, Direction direction, double target) const {
  const auto rises = [&](double v) { return slope(branch, direction, v) >= -slope_tolerance_; };
  if (!rises(branch.start_input)) return false;
  if (pace(direction).lowest_at_start) return true;
  const auto [lo, hi] = std::minmax(branch.start_input, target);
  for (const double v : pace(direction).flattest)
    if (lo < v && v < hi && !rises(v)) return false;
  return rises(target);
}

Branch ExponentialConvergence::threshold_branch(Direction direction) const {
  const Point low = parameters_.lower_point(), high = parameters_.upper_point();
  const auto [start, target] =
      direction == Direction::ascending ? std::pair(low, high) : std::pair(high, low);
  const double offset = start.level - parameters_.curve(direction).value(start.input);
  Branch branch{start.input, start.level, offset, 0.0, true};
  branch.coefficient = branch.offset / pace(direction).phi(between(start.input, target.input));
  branch.increasing = is_increasing(branch, direction, target.input);
  return branch;
}

Branch ExponentialConvergence::virgin_branch() const {
  const Point low = parameters_.lower_point();
  return {low.input, low.level, 0.0, 0.0, true};
}

// Returns the term that a reversal at the present point adds to the coefficient of the new branch:
//
//   [x_s - f_below(v_s)] / phi(d)
//
//   v_s, x_s    input and output at the reversal
//   f_below     the branch that ended at the target of the new branch
//   d           distance from v_s to the target
//   phi(d)      (1 - e^{-k d}) / k, with the convergence rate k
//
// The difference in brackets is the height of the loop. In a tiny loop it is lost in rounding. The code then
// computes it from the difference of the slopes of the loop's two sides; the relative error is the square of
// the loop's size. On the virgin curve a loop is never tiny, because the curve does not pass through the
// target L_0 (lower end of the major loop).
double ExponentialConvergence::added_coefficient(const HysteresisState& state, double offset,
                                                 double target) const {
  const std::size_t top = state.depth() - 1;
  const Direction old_direction = state.direction(), new_direction = opposite(old_direction);
  const Convergence& convergence = pace(new_direction);
  const Branch reference{input_range().lo, 0.0, 0.0, 0.0, true};
  const Branch& below = top > 0 ? state.branches[top - 1] : reference;
  const double size = std::abs(target - state.input), d = between(target, state.input);
  const double largest_k = std::max(std::abs(ascending_.k), std::abs(descending_.k));
  const bool closes = top > 0 || state.origin != Origin::virgin;
  if (closes && std::max(size / input_range().span(), d * largest_k) < 1e-6) {
    const double middle = state.input + (target - state.input) / 2.0;
    const double opening =
        slope(below, new_direction, middle) - slope(state.branches[top], old_direction, middle);
    return sign(new_direction) * opening * size / convergence.precise_phi(d);
  }
  const double distance =
      offset - below.offset + below.coefficient * convergence.phi(between(state.input, below.start_input));
  return distance / convergence.precise_phi(d);
}

Branch ExponentialConvergence::reversed(const HysteresisState& state) const {
  const std::size_t top = state.depth() - 1;
  const Direction way = opposite(state.direction());
  const double target = state.branches[top].start_input;
  Branch branch{state.input, state.level, state.level - parameters_.curve(way).value(state.input), 0.0, true};
  if (top > 0) {
    const Branch& below = state.branches[top - 1];
    branch.coefficient = below.coefficient * pace(way).decay(between(state.input, below.start_input));
  }
  branch.coefficient += added_coefficient(state, branch.offset, target);
  // The coefficient is infinite if its divisor, phi of the distance to the target, is a denormal number. The
  // branch is then flagged as not increasing.
  const bool overflow = !std::isfinite(branch.coefficient);
  if (overflow) branch.coefficient = 0.0;
  branch.increasing = !overflow && is_increasing(branch, way, target);
  return branch;
}

template class MemoryModel<ExponentialConvergence>;

Hysteresis::Hysteresis(HysteresisParameters parameters) : Hysteresis(beyond_limit(std::move(parameters))) {
  check_branches(this->parameters());
}

Hysteresis Hysteresis::beyond_limit(HysteresisParameters parameters) {
  check_curves(parameters);
  return Hysteresis(ExponentialConvergence(std::move(parameters)));
}

Prediction Hysteresis::forward(const State& state, double input) const {
  Prediction step = Levels::forward(state, input);
  step.value = parameters().output(step.value);
  return step;
}

FoundInput Hysteresis::inverse(const State& state, double output) const {
  const std::optional<OutputMap>& map = parameters().output_map;
  if (!map || !std::isfinite(output)) return Levels::inverse(state, output);
  const Prediction wanted = map->inverse(output);
  FoundInput found = Levels::inverse(state, wanted.value);
  found.saturated |= wanted.saturated;
  return found;
}

Prediction Hysteresis::advance(State& state, double input) const {
  Prediction step = Levels::advance(state, input);
  step.value = state.output = parameters().output(state.level);
  return step;
}

Prediction Hysteresis::advance(State& state, const FoundInput& found) const {
  Prediction step = Levels::advance(state, found);
  step.value = state.output = parameters().output(state.level);
  return step;
}

}  // namespace hystcan::model
