#include "model/prandtl_ishlinskii.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <utility>

#include "base/text.h"
#include "model/fingerprint.h"
#include "model/memory_text.h"

namespace hystcan::model {

static_assert(HysteresisOperator<PrandtlIshlinskii>);

namespace {

std::string element(const char* list, std::size_t i) { return text_of(list, "[", i, "]"); }

void check_finite(const std::string& what, double value) {
  if (!std::isfinite(value)) refuse(what, " = ", value, ", expected a finite number");
}

void check_range(const Interval& range) {
  if (std::isfinite(range.lo) && std::isfinite(range.span()) && range.lo < range.hi) return;
  refuse("input_range [", range.lo, ", ", range.hi, "], expected finite lo < hi");
}

void check_count(const char* what, std::size_t actual, std::size_t expected) {
  if (actual == expected) return;
  refuse(actual, " ", what, ", expected ", expected);
}

void check_thresholds(const std::vector<double>& thresholds) {
  double before = 0.0;
  for (std::size_t i = 0; i < thresholds.size(); ++i) {
    check_finite(element("thresholds", i), thresholds[i]);
    if (thresholds[i] <= before)
      refuse(element("thresholds", i), " = ", thresholds[i], ", expected more than ", before);
    before = thresholds[i];
  }
}

// Returns the slopes W_i = w_0 + ... + w_i of the output, i = 0 ... m, from `gain` (w_0) and the weights.
std::vector<double> slopes_of(double gain, const std::vector<double>& weights) {
  if (!std::isfinite(gain) || gain <= 0) refuse("gain = ", gain, ", expected a positive number");
  std::vector<double> slopes{gain};
  double magnitude = gain;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    check_finite(element("weights", i), weights[i]);
    slopes.push_back(slopes.back() + weights[i]);
    magnitude += std::abs(weights[i]);
    if (!(slopes.back() > 1e-12 * magnitude))
      refuse("gain + ... + ", element("weights", i), " = ", slopes.back(),
             ", expected a positive sum, more than 1e-12 of the sum of the absolute values");
  }
  return slopes;
}

std::uint64_t fingerprint_of(const PrandtlIshlinskiiParameters& p) {
  Fingerprint print;
  print.add(PrandtlIshlinskii::kind(), p.input_unit, p.output_unit, p.input_range.lo, p.input_range.hi,
            p.offset, p.gain, p.thresholds, p.weights);
  return print.value();
}

auto numbers(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::ArrayXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}
auto numbers(std::vector<double>& values) {
  return Eigen::Map<Eigen::ArrayXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

// Returns the outputs of all plays at `input` as an Eigen expression, which is computed when it is used:
// max(v - r, min(v + r, y)), with the input v, thresholds r and previous outputs y.
template <class Array>
auto moved(const Array& plays, const Array& thresholds, double input) {
  return (input - thresholds).max((input + thresholds).min(plays));
}

Prediction not_finite(double value) { return {value, false, true, false}; }

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

PrandtlIshlinskii::PrandtlIshlinskii(PrandtlIshlinskiiParameters parameters)
    : parameters_(std::move(parameters)) {
  check_range(parameters_.input_range);
  check_finite("offset", parameters_.offset);
  check_count("weights", parameters_.weights.size(), parameters_.thresholds.size());
  check_thresholds(parameters_.thresholds);
  slopes_ = slopes_of(parameters_.gain, parameters_.weights);
  fingerprint_ = fingerprint_of(parameters_);
}

PlayState PrandtlIshlinskii::virgin(double input) const {
  return restore(input, std::vector<double>(parameters_.thresholds.size(), input));
}

PlayState PrandtlIshlinskii::restore(double input, std::span<const double> plays) const {
  const Interval& range = input_range();
  if (!range.contains(input))
    refuse("input = ", input, ", expected a number from ", range.lo, " to ", range.hi);
  check_count("plays", plays.size(), parameters_.thresholds.size());
  const double rounding = 1e-12 * std::max(std::abs(range.lo), std::abs(range.hi));
  double play_before = input, threshold_before = 0.0;
  for (std::size_t i = 0; i < plays.size(); ++i) {
    const double room = parameters_.thresholds[i] - threshold_before;
    if (!(std::abs(plays[i] - play_before) <= room + rounding))
      refuse(element("plays", i), " = ", plays[i], ", expected within ", room, " of ", play_before);
    play_before = plays[i];
    threshold_before = parameters_.thresholds[i];
  }
  State state{input, 0.0, {plays.begin(), plays.end()}};
  advance(state, input);
  return state;
}

Interval PrandtlIshlinskii::reachable(const State& state) const {
  return {output_at(state, input_range().lo), output_at(state, input_range().hi)};
}

Prediction PrandtlIshlinskii::forward(const State& state, double input) const {
  if (!std::isfinite(input)) return not_finite(nan);
  return {output_at(state, clamped(input)), clamped(input) != input};
}

Prediction PrandtlIshlinskii::inverse(const State& state, double output) const {
  if (!std::isfinite(output)) return not_finite(nan);
  if (output == state.output) return {state.input};
  const bool rising = output > state.output;
  const double edge = rising ? input_range().hi : input_range().lo;
  const double reach = output_at(state, edge);
  if (rising ? output > reach : output < reach) return {edge, true};
  const auto [lo, hi] = std::minmax(state.input, edge);
  return {std::clamp(input_at(state, output), lo, hi)};
}

Prediction PrandtlIshlinskii::advance(State& state, double input) const {
  if (!std::isfinite(input)) return not_finite(state.output);
  state.input = clamped(input);
  numbers(state.plays) =
      moved(numbers(std::as_const(state.plays)), numbers(parameters_.thresholds), state.input);
  state.output = output_at(state, state.input);
  return {state.output, state.input != input};
}

std::string_view PrandtlIshlinskii::save(const State& state, std::span<char> text) const {
  MemoryText memory(text, kind(), fingerprint_);
  memory.line("input", state.input);
  memory.line("output", state.output);
  memory.list("plays", state.plays, std::identity());
  return memory.text();
}

double PrandtlIshlinskii::clamped(double input) const {
  return std::clamp(input, input_range().lo, input_range().hi);
}

double PrandtlIshlinskii::output_at(const State& state, double input) const {
  const auto plays = moved(numbers(state.plays), numbers(parameters_.thresholds), input);
  return (parameters_.offset + parameters_.gain * input) + (numbers(parameters_.weights) * plays).sum();
}

// Returns the input that gives `output`. Follows the output from kink to kink; a kink is the input at which
// the next play starts to move. While the plays 1 to i move, the output has the slope w_0 + ... + w_i
// (`slopes_[i]`: sum of the gain w_0 and the weights of these plays).
double PrandtlIshlinskii::input_at(const State& state, double output) const {
  const double direction = output > state.output ? 1.0 : -1.0;
  double input = state.input, reached = state.output;
  std::size_t moving = 0;
  for (; moving < state.plays.size(); ++moving) {
    const double kink = state.plays[moving] + direction * parameters_.thresholds[moving];
    const double output_at_kink = reached + slopes_[moving] * (kink - input);
    if (direction * (output - output_at_kink) <= 0) break;
    input = kink;
    reached = output_at_kink;
  }
  return input + (output - reached) / slopes_[moving];
}

}  // namespace hystcan::model
