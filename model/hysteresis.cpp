#include "model/hysteresis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "model/validity.h"

namespace hystcan::model {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

constexpr double sign(Direction direction) { return direction == Direction::ascending ? 1.0 : -1.0; }

constexpr Direction opposite(Direction direction) {
  return direction == Direction::ascending ? Direction::descending : Direction::ascending;
}

}  // namespace

/// A stretch of path on one branch, with what becomes of the memory when it is taken.
struct Hysteresis::Segment {
  Branch branch;
  Direction direction = Direction::ascending;  // of the branch
  double begin_input = 0.0;                    // a point of the branch at or before the goal
  double begin_output = 0.0;
  double end_input = 0.0;  // a point of the branch beyond the goal
  std::size_t kept = 0;    // branches that stay, the one travelled included unless it is new
  bool is_new = false;
  bool backwards = false;          // memory full
  const Branch* passed = nullptr;  // whose start was the last turning point reached
};

double Hysteresis::Convergence::phi(double d) const {
  if (steep) return (1.0 - std::exp(-k * d)) * reciprocal;
  return k == 0.0 ? d : -std::expm1(-k * d) * reciprocal;
}
double Hysteresis::Convergence::decay(double d) const { return std::exp(-k * d); }

Hysteresis::Hysteresis(HysteresisParameters parameters) : parameters_(std::move(parameters)) {
  check_validity(parameters_);
  ascending_ = convergence(Direction::ascending);
  descending_ = convergence(Direction::descending);
  lower_ = {input_range().lo, parameters_.descending.value(input_range().lo), 0.0, 0.0, true};
  upper_ = {input_range().hi, parameters_.ascending.value(input_range().hi), 0.0, 0.0, true};
  const double span = input_range().span();
  const double steepest_k = std::max(std::abs(parameters_.k_ascending), std::abs(parameters_.k_descending));
  slope_tolerance_ = 1e-9 * (upper_.start_output - lower_.start_output) / span;
  newton_tolerance_ = span * std::sqrt(1e-16 / (100.0 + steepest_k * span));
  lower_ = threshold_branch(Direction::ascending);
  upper_ = threshold_branch(Direction::descending);
}

Hysteresis::Convergence Hysteresis::convergence(Direction direction) const {
  const double k = direction == Direction::ascending ? parameters_.k_ascending : parameters_.k_descending;
  Convergence pace;
  const double k_span = std::abs(k) * input_range().span();
  if (k_span > 1e-17) pace = {k, 1.0 / k, true, k_span > 1.0};
  constexpr int points = 400;
  for (int i = 0; i <= points; ++i) {
    const double v = input_range().lo + input_range().span() * i / points;
    const double bend = sign(direction) * curve(direction).curvature(v) + k * curve(direction).slope(v);
    pace.lowest_at_start = pace.lowest_at_start && bend >= 0.0;
  }
  return pace;
}

const ReferenceCurve& Hysteresis::curve(Direction direction) const {
  return direction == Direction::ascending ? parameters_.ascending : parameters_.descending;
}

const Hysteresis::Convergence& Hysteresis::pace(Direction direction) const {
  return direction == Direction::ascending ? ascending_ : descending_;
}

double Hysteresis::value(const Branch& branch, Direction direction, double input) const {
  const double d = std::abs(input - branch.start_input);
  return curve(direction).value(input) + (branch.offset - branch.coefficient * pace(direction).phi(d));
}

double Hysteresis::slope(const Branch& branch, Direction direction, double input) const {
  const double d = std::abs(input - branch.start_input);
  return curve(direction).slope(input) - sign(direction) * branch.coefficient * pace(direction).decay(d);
}

bool Hysteresis::is_increasing(const Branch& branch, Direction direction, double target) const {
  if (!(slope(branch, direction, branch.start_input) >= -slope_tolerance_)) return false;
  return pace(direction).lowest_at_start || slope(branch, direction, target) >= -slope_tolerance_;
}

Branch Hysteresis::threshold_branch(Direction direction) const {
  Branch branch = direction == Direction::ascending ? lower_ : upper_;
  const double target = (direction == Direction::ascending ? upper_ : lower_).start_input;
  branch.offset = branch.start_output - curve(direction).value(branch.start_input);
  branch.coefficient = branch.offset / pace(direction).phi(std::abs(target - branch.start_input));
  branch.increasing = is_increasing(branch, direction, target);
  return branch;
}

HysteresisState Hysteresis::virgin(double input, std::size_t capacity) const {
  if (parameters_.symmetry == Symmetry::even) input = std::abs(input);
  if (!input_range().contains(input))
    throw std::invalid_argument("initial input " + std::to_string(input) + ", expected " +
                                std::to_string(input_range().lo) + " to " + std::to_string(input_range().hi) +
                                " " + parameters_.input_unit);
  if (input == input_range().hi) return at_upper_threshold(capacity);
  HysteresisState state = at_lower_threshold(capacity);
  Branch branch = lower_;
  branch.offset = branch.coefficient = 0.0;
  branch.increasing = true;
  state.branches.keep(0);
  state.branches.push(branch);
  state.input = input;
  state.output = parameters_.ascending.value(input);
  return state;
}

HysteresisState Hysteresis::at_lower_threshold(std::size_t capacity) const {
  return at_threshold(Direction::ascending, capacity);
}

HysteresisState Hysteresis::at_upper_threshold(std::size_t capacity) const {
  return at_threshold(Direction::descending, capacity);
}

HysteresisState Hysteresis::at_threshold(Direction from, std::size_t capacity) const {
  if (capacity < 4)
    throw std::invalid_argument("memory for " + std::to_string(capacity) + " branches, expected at least 4");
  const Branch& branch = from == Direction::ascending ? lower_ : upper_;
  HysteresisState state{BranchStack(capacity), from, branch.start_input, branch.start_output, 0};
  state.branches.push(branch);
  return state;
}

// [x_s - f_below(v_s)] / phi(|v_target - v_s|) of a reversal at the present point.
//
// In a tiny loop the distance between its two sides drowns in rounding; there it follows from the difference
// of their slopes, which is exact to the square of the loop's size. The virgin curve does not pass through
// its target L_0, so that loops between the two are not tiny.
double Hysteresis::added_coefficient(const HysteresisState& state, double offset, double target) const {
  const std::size_t top = state.depth() - 1;
  const Direction old_way = state.direction(), new_way = opposite(old_way);
  const Convergence& convergence = pace(new_way);
  const Branch reference{input_range().lo, 0.0, 0.0, 0.0, true};
  const Branch& below = top > 0 ? state.branches[top - 1] : reference;
  const double size = std::abs(target - state.input);
  const double largest_k = std::max(std::abs(ascending_.k), std::abs(descending_.k));
  const bool closes =
      top > 0 || state.branches[0].offset == lower_.offset || old_way == Direction::descending;
  if (closes && size * std::max(1.0 / input_range().span(), largest_k) < 1e-6) {
    const double middle = state.input + (target - state.input) / 2.0;
    const double opening = slope(below, new_way, middle) - slope(state.branches[top], old_way, middle);
    return sign(new_way) * opening * size / convergence.phi(size);
  }
  const double distance =
      offset - below.offset + below.coefficient * convergence.phi(std::abs(state.input - below.start_input));
  return distance / convergence.phi(size);
}

Branch Hysteresis::reversed(const HysteresisState& state) const {
  const std::size_t top = state.depth() - 1;
  const Direction way = opposite(state.direction());
  const double target = state.branches[top].start_input;
  Branch branch{state.input, state.output, state.output - curve(way).value(state.input), 0.0, true};
  if (top > 0) {
    const Branch& below = state.branches[top - 1];
    branch.coefficient = below.coefficient * pace(way).decay(std::abs(state.input - below.start_input));
  }
  branch.coefficient += added_coefficient(state, branch.offset, target);
  branch.increasing = is_increasing(branch, way, target);
  return branch;
}

// The one search through the memory, by input (forward) or by output (inverse): turning points are ordered in
// both. `to` lies strictly between the thresholds and differs from `from`.
template <double Branch::*axis>
Hysteresis::Segment Hysteresis::locate(const HysteresisState& state, double from, double to) const {
  const BranchStack& branches = state.branches;
  const std::size_t top = branches.size() - 1;
  const Direction way = to > from ? Direction::ascending : Direction::descending;
  const auto reached = [&](const Branch& target) { return sign(way) * (to - target.*axis) >= 0.0; };

  Segment segment;
  segment.begin_input = state.input;
  segment.begin_output = state.output;
  segment.kept = top + 1;
  const bool turned = way != state.direction();
  if (turned && (top == 0 || !reached(branches[top]))) {
    segment.end_input = branches[top].start_input;
    segment.is_new = !branches.full();
    segment.backwards = branches.full();
    segment.branch = segment.is_new ? reversed(state) : branches[top];
    segment.direction = segment.is_new ? way : opposite(way);
    return segment;
  }
  std::size_t j = turned ? top - 1 : top;
  while (j >= 2 && reached(branches[j - 1])) j -= 2;
  if (j < top) {
    segment.passed = &branches[j + 1];
    segment.begin_input = segment.passed->start_input;
    segment.begin_output = segment.passed->start_output;
  }
  segment.end_input = j > 0                         ? branches[j - 1].start_input
                      : way == Direction::ascending ? upper_.start_input
                                                    : lower_.start_input;
  segment.kept = j + 1;
  segment.branch = branches[j];
  segment.direction = way;
  return segment;
}

// Still between the last known point and the target of the branch being travelled: most steps.
bool Hysteresis::stays_on_branch(const HysteresisState& state, double input) const {
  const std::size_t top = state.depth() - 1;
  const bool up = state.direction() == Direction::ascending;
  const double target = top > 0 ? state.branches[top - 1].start_input : (up ? upper_ : lower_).start_input;
  return up ? state.input < input && input < target : target < input && input < state.input;
}

Prediction Hysteresis::forward(const HysteresisState& state, double input) const {
  if (!std::isfinite(input)) return {nan, true, true};
  if (parameters_.symmetry == Symmetry::even) input = std::abs(input);
  if (stays_on_branch(state, input)) return on_branch(state, input);
  const double v = std::clamp(input, lower_.start_input, upper_.start_input);
  const bool saturated = v != input;
  if (v == state.input) return {state.output, saturated, state.branches.back().increasing};
  if (v == lower_.start_input) return {lower_.start_output, saturated, lower_.increasing};
  if (v == upper_.start_input) return {upper_.start_output, saturated, upper_.increasing};
  const Segment segment = locate<&Branch::start_input>(state, state.input, v);
  return {follow(segment, v), saturated, segment.branch.increasing};
}

Prediction Hysteresis::advance(HysteresisState& state, double input) const {
  if (!std::isfinite(input)) return {state.output, true, state.branches.back().increasing};
  if (parameters_.symmetry == Symmetry::even) input = std::abs(input);
  if (stays_on_branch(state, input)) {
    const Prediction step = on_branch(state, input);
    state.input = input;
    state.output = step.value;
    return step;
  }
  const double v = std::clamp(input, lower_.start_input, upper_.start_input);
  if (v != state.input && (v == lower_.start_input || v == upper_.start_input)) {
    const Branch& branch = v == lower_.start_input ? lower_ : upper_;
    state.bottom = v == lower_.start_input ? Direction::ascending : Direction::descending;
    state.branches.keep(0);
    state.branches.push(branch);
    state.output = branch.start_output;
  } else if (v != state.input) {
    const Segment segment = locate<&Branch::start_input>(state, state.input, v);
    state.output = follow(segment, v);
    state.branches.keep(segment.kept);
    if (segment.is_new) state.branches.push(segment.branch);
    if (segment.backwards) ++state.merged;
  }
  state.input = v;
  return {state.output, v != input, state.branches.back().increasing};
}

Prediction Hysteresis::on_branch(const HysteresisState& state, double input) const {
  return {value(state.branches.back(), state.direction(), input), false, state.branches.back().increasing};
}

double Hysteresis::follow(const Segment& segment, double input) const {
  if (segment.passed && segment.passed->start_input == input) return segment.passed->start_output;
  return value(segment.branch, segment.direction, input);
}

Prediction Hysteresis::inverse(const HysteresisState& state, double output) const {
  if (!std::isfinite(output)) return {nan, true, true};
  if (output == state.output) return {state.input, false, state.branches.back().increasing};
  if (output > state.output && output >= upper_.start_output)
    return {upper_.start_input, output > upper_.start_output, upper_.increasing};
  if (output < state.output && output <= lower_.start_output)
    return {lower_.start_input, output < lower_.start_output, lower_.increasing};
  const Segment segment = locate<&Branch::start_output>(state, state.output, output);
  const bool at_turning_point = segment.passed && segment.passed->start_output == output;
  const double input = at_turning_point ? segment.passed->start_input : solve(segment, output);
  return {input, false, segment.branch.increasing};
}

// Newton's method from the nearest known point, kept inside a bracket that every step narrows.
double Hysteresis::solve(const Segment& segment, double output) const {
  const Branch& branch = segment.branch;
  const Direction way = segment.direction;
  double lo = std::min(segment.begin_input, segment.end_input);
  double hi = std::max(segment.begin_input, segment.end_input);
  const double rounding = 2e-16 * std::max(std::abs(upper_.start_output), std::abs(lower_.start_output));
  const double steep = 1e8 * slope_tolerance_;
  double v = segment.begin_input;
  double residual = segment.begin_output - output;
  double previous_step = hi - lo;
  for (int i = 0; i < 100 && hi - lo > 0.0 && std::abs(residual) > rounding; ++i) {
    (residual < 0.0 ? lo : hi) = v;
    const double gradient = slope(branch, way, v);
    const double step = residual / gradient;
    double next = v - step;
    if (std::abs(step) < newton_tolerance_ && gradient > steep) return std::clamp(next, lo, hi);
    const bool wild = !(gradient > 0.0) || (i > 2 && std::abs(step) > 0.5 * previous_step);
    if (wild || !(next > lo && next < hi)) {
      const bool try_end = !wild && i < 2;
      next = try_end ? (next <= lo ? lo : hi) : lo + (hi - lo) / 2.0;
      if (next == v) next = lo + (hi - lo) / 2.0;
      if (!try_end && (next == lo || next == hi)) break;
    }
    previous_step = std::abs(next - v);
    v = next;
    residual = value(branch, way, v) - output;
  }
  return v;
}

}  // namespace hystcan::model
