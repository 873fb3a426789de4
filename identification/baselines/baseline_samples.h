// Functions that all baseline fits use: they check the samples, choose the samples to fit, list the possible
// histories and run an operator over all samples.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "identification/baselines/baseline_models.h"
#include "model/hysteresis_operator.h"

namespace hystcan::identification {

/// Inputs that were applied before the first sample, to a model in its virgin state. Never empty.
using History = std::vector<double>;

/// Throws std::invalid_argument if the samples cannot be fitted; the reasons are listed in baseline_models.h.
void check(const Samples& samples);

/// Returns the indices of the samples to fit: at most 5000, evenly chosen from those with a positive weight.
std::vector<std::size_t> fitted_samples(const Samples& samples);

/// Returns only the samples that a fit needs: the first sample, the samples of fitted_samples(), and the
/// turning points of the input between them. The memory of an operator depends only on turning points.
/// Therefore the operator has the same output at these samples as in a run over all samples.
Samples reduced(const Samples& samples);

/// Returns the range of the samples, widened to contain every input, also those of the prehistory.
model::Interval widened_range(const Samples& samples);

/// Returns the input sequences that may have been applied before the first sample. A model is fitted once
/// after each of them. There are three (see baseline_models.h): the first input alone; up to range.hi and
/// then down to range.lo; down to range.lo and then up to range.hi. If samples.prehistory is not empty, it is
/// the fourth.
std::vector<History> histories(const Samples& samples, const model::Interval& range);

Eigen::VectorXd at(const std::vector<std::size_t>& places, std::span<const double> values);

/// Returns the state of an operator after the history: the history is applied to the virgin state.
template <model::HysteresisOperator Operator>
typename Operator::State after(const Operator& op, const History& history) {
  const model::Interval range = op.input_range();
  typename Operator::State state = op.virgin(std::clamp(history.front(), range.lo, range.hi));
  for (const double v : history) op.advance(state, v);
  return state;
}

/// Calls samples.go_on(); throws Stopped if go_on() returns false.
void look(const Samples& samples);

/// Runs an operator over all samples, after a history. Returns the value read(state) after each sample.
template <model::HysteresisOperator Operator, class Read>
std::vector<double> run(const Operator& op, const History& history, const Samples& samples, Read read) {
  look(samples);
  typename Operator::State state = after(op, history);
  std::vector<double> values;
  values.reserve(samples.input.size());
  for (const double v : samples.input) {
    op.advance(state, v);
    values.push_back(read(state));
  }
  return values;
}

/// Returns the output of one operator o_j (a play or a relay) at each sample, after a history. The output x
/// of a model is a weighted sum of such operators. It is linear in the weights w:
///
///   x = x_0 + w_0 v + sum_j w_j o_j[v],     w >= 0,     v: input
using OperatorColumn =
    std::function<std::vector<double>(std::size_t j, const History& history, const Samples& samples)>;

struct WeightedOperators {
  History history;      ///< history after which the fit is best
  double offset = 0.0;  ///< constant part of the output, x_0
  double gain = 0.0;    ///< weight of the input itself, w_0
  std::vector<double> weights;
  std::vector<double> prediction;  ///< predicted output of every sample
};

/// Fits offset, gain and weights of `operators` operators after each history, and returns the best fit. The
/// caller must have checked the samples.
WeightedOperators fit_weights(const Samples& samples, const std::vector<History>& histories,
                              std::size_t operators, const OperatorColumn& column);

}  // namespace hystcan::identification
