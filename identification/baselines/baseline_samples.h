// Common functions of all baseline fits: they check the samples, choose the samples to fit, list the possible
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

/// Inputs before the first sample, applied from the virgin state; never empty.
using History = std::vector<double>;

/// Throws std::invalid_argument as described in baseline_models.h.
void check(const Samples& samples);

/// Returns the indices of about 5000 evenly chosen samples of positive weight.
std::vector<std::size_t> fitted_samples(const Samples& samples);

/// Returns the samples that a fit runs over: the first sample, those of fitted_samples(), and the turning
/// points of the input between them. The memory of an operator consists of turning points, so its output at
/// these samples is the same as in a run over all samples.
Samples reduced(const Samples& samples);

/// Returns the range, widened to contain every input and the prehistory.
model::Interval widened_range(const Samples& samples);

/// Returns the four possible histories (baseline_models.h).
std::vector<History> histories(const Samples& samples, const model::Interval& range);

Eigen::VectorXd at(const std::vector<std::size_t>& places, std::span<const double> values);

/// Returns the state of the operator after the history, before the first sample.
template <model::HysteresisOperator Operator>
typename Operator::State after(const Operator& op, const History& history) {
  const model::Interval range = op.input_range();
  typename Operator::State state = op.virgin(std::clamp(history.front(), range.lo, range.hi));
  for (const double v : history) op.advance(state, v);
  return state;
}

/// Throws Stopped if the samples' go_on returns false.
void look(const Samples& samples);

/// Returns read(state) after each sample.
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

/// A weighted sum of operators (plays, relays). The output is linear in the weights.
///
///   x = x_0 + w_0 v + sum_j w_j o_j[v],     w >= 0
///
/// column(j, history, samples) returns the values of o_j at each of these samples, after a history.
using OperatorColumn =
    std::function<std::vector<double>(std::size_t j, const History& history, const Samples& samples)>;

struct WeightedOperators {
  History history;      ///< the given history that fits best
  double offset = 0.0;  ///< x_0
  double gain = 0.0;    ///< w_0
  std::vector<double> weights;
  std::vector<double> prediction;  ///< for every sample
};

/// Fits the weights. The caller must have checked the samples.
WeightedOperators fit_weights(const Samples& samples, const std::vector<History>& histories,
                              std::size_t operators, const OperatorColumn& column);

}  // namespace hystcan::identification
