#include "identification/baselines/weighted_operators.h"

#include <Eigen/Core>
#include <limits>

#include "identification/numerics/least_squares.h"

namespace hystcan::identification {
namespace {

using Eigen::Index;

// Columns: 1, v, o_1, o_2, ...
Fit fit_after(const History& history, const Samples& samples, const std::vector<std::size_t>& places,
              std::size_t operators, const OperatorColumn& column) {
  Eigen::MatrixXd rows(2 + static_cast<Index>(operators), static_cast<Index>(places.size()));
  rows.row(0).setOnes();
  rows.row(1) = at(places, samples.input).transpose();
  for (std::size_t j = 0; j < operators; ++j)
    rows.row(2 + static_cast<Index>(j)) = at(places, column(j, history, samples)).transpose();
  LeastSquares sum(rows.rows());
  for (std::size_t i = 0; i < places.size(); ++i)
    sum.add(rows.col(static_cast<Index>(i)), samples.output[places[i]], samples.weight[places[i]]);
  return sum.solve_nonnegative({0});
}

std::vector<double> predicted(const WeightedOperators& model, const Samples& samples,
                              const OperatorColumn& column) {
  std::vector<double> output;
  output.reserve(samples.input.size());
  for (const double v : samples.input) output.push_back(model.offset + model.gain * v);
  for (std::size_t j = 0; j < model.weights.size(); ++j) {
    if (model.weights[j] == 0.0) continue;
    const std::vector<double> values = column(j, model.history, samples);
    for (std::size_t n = 0; n < output.size(); ++n) output[n] += model.weights[j] * values[n];
  }
  return output;
}

}  // namespace

WeightedOperators fit_weights(const Samples& samples, const std::vector<History>& histories,
                              std::size_t operators, const OperatorColumn& column) {
  const ReducedSamples reduced(samples);
  const Samples fitted = reduced.samples();
  const std::vector<std::size_t> places = fitted_samples(fitted);
  Fit best{{}, std::numeric_limits<double>::infinity()};
  WeightedOperators result;
  for (const History& history : histories) {
    const Fit fit = fit_after(history, fitted, places, operators, column);
    if (!(fit.residual < best.residual)) continue;
    best = fit;
    result.history = history;
  }
  result.offset = best.x[0];
  result.gain = best.x[1];
  result.weights.assign(best.x.begin() + 2, best.x.end());
  result.prediction = predicted(result, samples, column);
  return result;
}

}  // namespace hystcan::identification
