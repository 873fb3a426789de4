#include "identification/baselines/baseline_samples.h"

#include <cmath>
#include <limits>

#include "base/text.h"
#include "identification/numerics/least_squares.h"

namespace hystcan::identification {
namespace {

void check_column(const char* name, std::span<const double> values, std::size_t size) {
  if (values.size() != size) refuse(values.size(), " values of ", name, ", expected ", size);
  for (std::size_t n = 0; n < values.size(); ++n)
    if (!std::isfinite(values[n])) refuse(name, " ", n, " is ", values[n], ", expected a finite number");
}

using Eigen::Index;

// Fits a weighted sum of operators (plays or relays) to the samples: finds offset, gain and the weight of
// each operator. Before the first sample, each operator gets the inputs in `history`. The order of the
// unknowns is offset, gain, weights.
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

void check(const Samples& samples) {
  check_column("prehistory", samples.prehistory, samples.prehistory.size());
  check_column("input", samples.input, samples.input.size());
  check_column("output", samples.output, samples.input.size());
  check_column("weight", samples.weight, samples.input.size());
  for (const double weight : samples.weight)
    if (weight < 0.0) refuse("weight is ", weight, ", expected a number >= 0");
  if (std::ranges::none_of(samples.weight, [](double weight) { return weight > 0.0; }))
    refuse("all weights are 0, expected a positive weight for at least one sample");
  const model::Interval& range = samples.range;
  if (!std::isfinite(range.lo) || !std::isfinite(range.span()) || !(range.lo < range.hi))
    refuse("range [", range.lo, ", ", range.hi, "], expected finite lo < hi");
}

void look(const Samples& samples) {
  if (samples.go_on && !samples.go_on()) throw Stopped();
}

std::vector<std::size_t> fitted_samples(const Samples& samples) {
  constexpr std::size_t most_fitted_samples = 5000;
  std::vector<std::size_t> weighted;
  for (std::size_t n = 0; n < samples.weight.size(); ++n)
    if (samples.weight[n] > 0.0) weighted.push_back(n);
  const std::size_t count = std::min(most_fitted_samples, weighted.size());
  std::vector<std::size_t> selected;
  for (std::size_t i = 0; i < count; ++i) selected.push_back(weighted[i * weighted.size() / count]);
  return selected;
}

Samples reduced(const Samples& samples) {
  const std::vector<double>& v = samples.input;
  const auto turns = [&](std::size_t n) { return (v[n] - v[n - 1]) * (v[n + 1] - v[n]) <= 0.0; };
  std::vector<bool> is_selected(v.size(), false);
  for (const std::size_t n : fitted_samples(samples)) is_selected[n] = true;
  Samples selected{samples.prehistory, {}, {}, {}, samples.range, samples.go_on};
  for (std::size_t n = 0; n < v.size(); ++n) {
    const bool fitted = is_selected[n];
    if (!fitted && n > 0 && (n + 1 == v.size() || !turns(n))) continue;
    selected.input.push_back(v[n]);
    selected.output.push_back(samples.output[n]);
    selected.weight.push_back(fitted ? samples.weight[n] : 0.0);
  }
  return selected;
}

model::Interval widened_range(const Samples& samples) {
  model::Interval range = samples.range;
  for (const auto* inputs : {&samples.prehistory, &samples.input})
    for (const double v : *inputs) range = {std::min(range.lo, v), std::max(range.hi, v)};
  return range;
}

std::vector<History> histories(const Samples& samples, const model::Interval& range) {
  std::vector<History> all{{samples.input.front()}, {range.hi, range.lo}, {range.lo, range.hi}};
  if (!samples.prehistory.empty()) all.emplace_back(samples.prehistory.begin(), samples.prehistory.end());
  return all;
}

Eigen::VectorXd at(const std::vector<std::size_t>& places, std::span<const double> values) {
  Eigen::VectorXd selected(static_cast<Eigen::Index>(places.size()));
  for (Eigen::Index i = 0; i < selected.size(); ++i)
    selected[i] = values[places[static_cast<std::size_t>(i)]];
  return selected;
}

WeightedOperators fit_weights(const Samples& samples, const std::vector<History>& histories,
                              std::size_t operators, const OperatorColumn& column) {
  const Samples fitted = reduced(samples);
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
