// The definitions of MemoryModel. Include it only in a source file that instantiates MemoryModel.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "base/words.h"
#include "model/memory_model.h"
#include "model/memory_text.h"

namespace hystcan::model {

/// The part of a branch on which the path arrives at its goal, and the change of the memory when the path
/// moves to the goal. The goal is an input in forward(), and an output in inverse().
template <BranchLaw Law>
struct MemoryModel<Law>::Segment {
  Branch branch;
  Direction direction = Direction::ascending;
  double begin = 0.0;           // input at which this part of the branch begins
  const Branch* end = nullptr;  // branch whose start is the end of this part, at or beyond the goal
  std::size_t kept = 0;         // number of branches that stay in the memory, without a new branch
  bool is_new = false;          // true: the path reverses, and `branch` is new
  bool backwards = false;       // true: the memory is full, and the path moves backwards on `branch`
  // On its way from the present input to the goal, the path can pass turning points. `passed` is the branch
  // that starts at the last one; null if the path passes none.
  const Branch* passed = nullptr;
};

template <BranchLaw Law>
MemoryModel<Law>::MemoryModel(Law law)
    : law_(std::move(law)),
      lower_(law_.threshold_branch(Direction::ascending)),
      upper_(law_.threshold_branch(Direction::descending)),
      rounding_(2e-16 * std::max(std::abs(upper_.start_level), std::abs(lower_.start_level))) {}

template <BranchLaw Law>
Interval MemoryModel<Law>::reachable(const State& state) const {
  return {std::min(state.level, lower_.start_level), upper_.start_level};
}

template <BranchLaw Law>
Interval MemoryModel<Law>::reachable(const State& state, Interval inputs) const {
  const auto [lo, hi] = std::minmax({forward(state, inputs.lo).value, forward(state, inputs.hi).value});
  return {lo, hi};
}

template <BranchLaw Law>
HysteresisState MemoryModel<Law>::virgin(double input, std::size_t capacity) const {
  input = folded(input);
  if (!input_range().contains(input))
    refuse("initial input ", input, ", expected ", input_range().lo, " to ", input_range().hi);
  if (input == input_range().hi) return at_upper_threshold(capacity);
  State state = from(Origin::virgin, capacity);
  put(state, input, law_.value(state.branches.back(), Direction::ascending, input));
  return state;
}

template <BranchLaw Law>
HysteresisState MemoryModel<Law>::at_lower_threshold(std::size_t capacity) const {
  return from(Origin::lower_threshold, capacity);
}

template <BranchLaw Law>
HysteresisState MemoryModel<Law>::at_upper_threshold(std::size_t capacity) const {
  return from(Origin::upper_threshold, capacity);
}

template <BranchLaw Law>
HysteresisState MemoryModel<Law>::from(Origin origin, std::size_t capacity) const {
  if (capacity < 4) refuse("memory for ", capacity, " branches, expected at least 4");
  const Branch branch = origin == Origin::virgin            ? law_.virgin_branch()
                        : origin == Origin::lower_threshold ? lower_
                                                            : upper_;
  State state{BranchStack(capacity), origin};
  const bool starts_elsewhere = origin == Origin::virgin;
  put(state, branch.start_input,
      starts_elsewhere ? law_.value(branch, Direction::ascending, branch.start_input) : branch.start_level);
  state.branches.push(branch);
  return state;
}

template <BranchLaw Law>
void MemoryModel<Law>::put(State& state, double input, double level) {
  state.input = input;
  state.level = state.output = level;
}

// Returns the branch whose start is the target of branch `index`.
template <BranchLaw Law>
const Branch& MemoryModel<Law>::target(const State& state, std::size_t index) const {
  if (index > 0) return state.branches[index - 1];
  return state.direction(0) == Direction::ascending ? upper_ : lower_;
}

// Moves along the present branch to an input strictly before its target.
template <BranchLaw Law>
void MemoryModel<Law>::go_to(State& state, std::size_t index, const char* what, double input) const {
  const double before = state.input, end = target(state, state.depth() - 1).start_input;
  if (!(std::min(before, end) < input && input < std::max(before, end)))
    throw MemoryError(
        index, text_of(what, " is ", input, ", expected a value strictly between the two previous ones, ",
                       before, " and ", end));
  put(state, input, law_.value(state.branches.back(), state.direction(), input));
}

// Restores a level (value of the branch) from a memory file, exact to the bit. Throws if the level that this
// model has computed differs by more than the tolerance.
template <BranchLaw Law>
void MemoryModel<Law>::restore_level(State& state, std::size_t index, double level) const {
  const double tolerance = 1e-9 * (upper_.start_level - lower_.start_level);
  if (!(std::abs(level - state.level) <= tolerance))
    throw MemoryError(index, text_of("output ", level, " at input ", state.input, ", expected ", state.level,
                                     "; the memory may belong to another model"));
  put(state, state.input, level);
}

template <BranchLaw Law>
HysteresisState MemoryModel<Law>::remembering(const TurningPoints& points, std::size_t capacity) const {
  State state = from(points.origin, capacity);
  const std::size_t count = points.inputs.size();
  if (!points.levels.empty() && points.levels.size() != count)
    throw MemoryError(count,
                      text_of(points.levels.size(), " outputs of ", count,
                              " turning points, expected one output for each turning point or no output"));
  for (std::size_t i = 0; i < count; ++i) {
    go_to(state, i, "turning point", folded(points.inputs[i]));
    if (!points.levels.empty()) restore_level(state, i, points.levels[i]);
    if (state.branches.full())
      throw MemoryError(i, text_of("more than ", i,
                                   " turning points, expected at most as many as fit into a "
                                   "memory of ",
                                   capacity, " branches"));
    state.branches.push(law_.reversed(state));
  }
  if (folded(points.input) != state.input) go_to(state, count, "input", folded(points.input));
  if (points.level) restore_level(state, count, *points.level);
  state.merged = points.merged;
  return state;
}

// Finds the branch on which the path from `from` arrives at `to`. Both are inputs (for forward) or levels,
// which are values of the branch (for inverse). The same search works for both, because the turning points
// are ordered in both. `to` must be strictly between the thresholds and differ from `from`.
template <BranchLaw Law>
template <double Branch::*axis>
typename MemoryModel<Law>::Segment MemoryModel<Law>::locate(const State& state, double from,
                                                            double to) const {
  const BranchStack& branches = state.branches;
  const std::size_t top = branches.size() - 1;
  const Direction way = to > from ? Direction::ascending : Direction::descending;
  const auto reached = [&](const Branch& target) { return sign(way) * (to - target.*axis) >= 0.0; };

  Segment segment;
  segment.begin = state.input;
  segment.kept = top + 1;
  const bool turned = way != state.direction();
  if (turned && (top == 0 || !reached(branches[top]))) {
    segment.end = &branches[top];
    segment.is_new = !branches.full();
    segment.backwards = branches.full();
    segment.branch = segment.is_new ? law_.reversed(state) : branches[top];
    segment.direction = segment.is_new ? way : opposite(way);
    return segment;
  }
  std::size_t j = turned ? top - 1 : top;
  while (j >= 2 && reached(branches[j - 1])) j -= 2;
  if (j < top) {
    segment.passed = &branches[j + 1];
    segment.begin = segment.passed->start_input;
  }
  segment.end = &target(state, j);
  segment.kept = j + 1;
  segment.branch = branches[j];
  segment.direction = way;
  return segment;
}

// Returns true if `to` is between the present point and the target of the present branch. `axis` selects if
// inputs or levels (values of the branch) are compared. Such a step adds and removes no turning point. Most
// steps are of this kind.
template <BranchLaw Law>
template <double Branch::*axis>
bool MemoryModel<Law>::stays_on_branch(const State& state, double from, double to) const {
  const double end = target(state, state.depth() - 1).*axis;
  return state.direction() == Direction::ascending ? from < to && to < end : end < to && to < from;
}

template <BranchLaw Law>
inline Prediction MemoryModel<Law>::on_branch(const State& state, double input) const {
  const Branch& branch = state.branches.back();
  return {law_.value(branch, state.direction(), input), false, branch.increasing, true};
}

template <BranchLaw Law>
Prediction MemoryModel<Law>::forward(const State& state, double input) const {
  input = folded(input);
  if (stays_on_branch<&Branch::start_input>(state, state.input, input)) return on_branch(state, input);
  if (!std::isfinite(input)) return {std::numeric_limits<double>::quiet_NaN(), false, true, false};
  const double v = std::clamp(input, lower_.start_input, upper_.start_input);
  const bool saturated = v != input;
  if (v == state.input) return {state.level, saturated, state.branches.back().increasing, true};
  if (v == lower_.start_input) return {lower_.start_level, saturated, lower_.increasing, true};
  if (v == upper_.start_input) return {upper_.start_level, saturated, upper_.increasing, true};
  const Segment segment = locate<&Branch::start_input>(state, state.input, v);
  return {follow(segment, v), saturated, segment.branch.increasing, true};
}

template <BranchLaw Law>
inline Prediction MemoryModel<Law>::advance(State& state, double input) const {
  input = folded(input);
  if (!stays_on_branch<&Branch::start_input>(state, state.input, input)) return advance_past(state, input);
  const Prediction step = on_branch(state, input);
  put(state, input, step.value);
  return step;
}

// Advances by a step that is not covered by stays_on_branch(): the input reverses, reaches a target or a
// threshold, does not change, or is not finite.
template <BranchLaw Law>
Prediction MemoryModel<Law>::advance_past(State& state, double input) const {
  if (!std::isfinite(input)) return {state.level, false, state.branches.back().increasing, false};
  const double v = std::clamp(input, lower_.start_input, upper_.start_input);
  if (v != state.input && (v == lower_.start_input || v == upper_.start_input)) {
    const bool low = v == lower_.start_input;
    state.origin = low ? Origin::lower_threshold : Origin::upper_threshold;
    state.branches.keep(0);
    state.branches.push(low ? lower_ : upper_);
    put(state, v, state.branches.back().start_level);
  } else if (v != state.input) {
    const Segment segment = locate<&Branch::start_input>(state, state.input, v);
    put(state, v, follow(segment, v));
    state.branches.keep(segment.kept);
    if (segment.is_new) state.branches.push(segment.branch);
    if (segment.backwards) ++state.merged;
  }
  state.input = v;
  return {state.level, v != input, state.branches.back().increasing, true};
}

template <BranchLaw Law>
double MemoryModel<Law>::follow(const Segment& segment, double input) const {
  if (segment.passed && segment.passed->start_input == input) return segment.passed->start_level;
  return law_.value(segment.branch, segment.direction, input);
}

template <BranchLaw Law>
inline Prediction MemoryModel<Law>::advance(State& state, const FoundInput& found) const {
  if (found.near.slope > 0.0) state.near = found.near;
  if (!found.is_met || !stays_on_branch<&Branch::start_input>(state, state.input, found.value))
    return advance(state, found.value);
  put(state, found.value, found.near(found.value));
  return {state.level, false, found.increasing, true};
}

template <BranchLaw Law>
FoundInput MemoryModel<Law>::inverse(const State& state, double output) const {
  const bool increasing = state.branches.back().increasing;
  if (is_rounding(output - state.level)) return {{state.input, false, increasing, true}};
  if (stays_on_branch<&Branch::start_level>(state, state.level, output))
    return solve(state, state.branches.back(), state.direction(), state.input,
                 target(state, state.depth() - 1), output);
  if (!std::isfinite(output)) return {{std::numeric_limits<double>::quiet_NaN(), false, true, false}};
  if (output > state.level && output >= upper_.start_level)
    return {{upper_.start_input, output > upper_.start_level, upper_.increasing, true}};
  // The path is on the virgin curve, below the output of L_0. A falling branch would end at L_0, so no lower
  // output can be reached.
  if (output < state.level && state.level < lower_.start_level)
    return {{state.input, true, increasing, true}};
  if (output < state.level && output <= lower_.start_level)
    return {{lower_.start_input, output < lower_.start_level, lower_.increasing, true}};
  const Segment segment = locate<&Branch::start_level>(state, state.level, output);
  if (segment.passed && is_rounding(output - segment.passed->start_level))
    return {{segment.passed->start_input, false, segment.branch.increasing, true}};
  return solve(state, segment.branch, segment.direction, segment.begin, *segment.end, output);
}

// Returns the input at which `branch` has the value `level`. Searches between the input `begin` and the point
// where the branch `end` starts. If `level` differs from the level of this point only by rounding, returns
// the input of this point, so that rounding alone makes no turning point.
//
// The first guess is computed from `state.near`, the last point that an earlier inverse evaluated. In most
// steps, one evaluation at the guess is sufficient. After a reversal, this point is on another branch, and
// the search needs one more evaluation; reversals are rare.
template <BranchLaw Law>
inline FoundInput MemoryModel<Law>::solve(const State& state, const Branch& branch, Direction direction,
                                          double begin, const Branch& end, double level) const {
  if (is_rounding(level - end.start_level)) return {{end.start_input, false, branch.increasing, true}};
  const RootTolerance tolerance{rounding_, law_.third_derivative_bound(branch, direction)};
  double guess = state.near.at + step_to(level, state.near).length;
  const double lo = std::min(begin, end.start_input), hi = std::max(begin, end.start_input);
  if (lo < guess && guess < hi) {
    const Expansion here{guess, law_.jet(branch, direction, guess)};
    const RootStep step = step_to(level, here);
    guess += step.length;
    if (lo < guess && guess < hi && is_last(step, here, tolerance))
      return {{guess, false, branch.increasing, true}, here, true};
  }
  const Root root = root_of_increasing([&](double v) { return law_.jet(branch, direction, v); },
                                       {begin, end.start_input, guess}, level, tolerance);
  return {{root.input, false, branch.increasing, true}, root.near, root.is_met};
}

template <BranchLaw Law>
std::string_view MemoryModel<Law>::save(const State& state, std::span<char> buffer) const {
  MemoryText text(buffer, kind(), fingerprint());
  const std::span<const Branch> turned(state.branches.begin() + 1, state.branches.end());
  text.line("origin", word_of(state.origin));
  text.list("turning_inputs", turned, [](const Branch& branch) { return branch.start_input; });
  text.list("turning_outputs", turned, [](const Branch& branch) { return branch.start_level; });
  text.line("input", state.input);
  text.line("output", state.level);
  text.line("merged", state.merged);
  return text.text();
}

}  // namespace hystcan::model
