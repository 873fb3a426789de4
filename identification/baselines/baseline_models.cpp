#include "identification/baselines/baseline_models.h"

#include <Eigen/Core>
#include <algorithm>
#include <utility>

#include "base/text.h"
#include "identification/baselines/baseline_samples.h"
#include "identification/baselines/fit_linear_mapping.h"
#include "identification/baselines/fit_prandtl_ishlinskii.h"
#include "identification/curve_basis.h"
#include "identification/numerics/least_squares.h"
#include "model/preisach.h"

namespace hystcan::identification {
namespace {

Eigen::VectorXd chebyshev(std::size_t order, const model::Interval& range, double input) {
  Eigen::VectorXd row(static_cast<Eigen::Index>(order) + 1);
  chebyshev_row(range, input, row);
  return row;
}

// Returns a Preisach model in which only cell j of the grid of relays has a weight.
model::Preisach relays(const model::Interval& range, std::size_t cells, std::size_t j) {
  std::vector<double> weights(cells, 0.0);
  weights[j] = 1.0;
  return model::Preisach({"", "", range, 0.0, 0.0, weights});
}

/// Shortens the ascending curve of the model to the number of coefficients that the descending curve has.
/// (The function with_ascending_from_lower() may have given the ascending curve more coefficients.) If the
/// shortened curve is not valid, the result has the descending curve as its ascending curve. Splines, and
/// curves that are short enough, stay unchanged.
model::HysteresisParameters of_one_order(model::HysteresisParameters p) {
  std::vector<double> a = p.ascending.coefficients();
  const std::size_t count = p.descending.coefficients().size();
  if (p.ascending.basis() == model::Basis::spline || count < 2 || a.size() <= count) return p;
  a.resize(count);
  const double open = p.upper_point().level - p.ascending.with(a).value(p.input_range().hi);
  a[0] += 0.5 * open;
  a[1] += 0.5 * open;
  const model::ReferenceCurve shorter = p.ascending.with(a);
  const double rounding = 1e-9 * p.output_range().span();
  const auto inside = [&](double v) {
    return shorter.slope(v) > 0.0 && shorter.value(v) <= p.descending.value(v) + rounding;
  };
  p.ascending =
      std::ranges::all_of(model::grid_of(p.input_range(), {}, 100), inside) ? shorter : p.descending;
  return p;
}

}  // namespace

BaselineModel fit_average(const Samples& samples, std::size_t order) {
  check(samples);
  if (order > 32) refuse("order ", order, ", expected 0 to 32");
  const model::Interval range = widened_range(samples);
  LeastSquares sum(static_cast<Eigen::Index>(order) + 1);
  for (const std::size_t n : fitted_samples(samples))
    sum.add(chebyshev(order, range, samples.input[n]), samples.output[n], samples.weight[n]);
  const Eigen::VectorXd coefficients = sum.solve().x;
  BaselineModel baseline{text_of("average, order ", order), order + 1, {}};
  for (const double v : samples.input)
    baseline.prediction.push_back(coefficients.dot(chebyshev(order, range, v)));
  return baseline;
}

BaselineModel fit_preisach(const Samples& samples, std::size_t levels) {
  check(samples);
  if (levels < 1) refuse(levels, " levels, expected at least 1");
  const model::Interval range = widened_range(samples);
  const std::size_t cells = levels * (levels + 1) / 2;
  const auto column = [&](std::size_t j, const History& history, const Samples& subset) {
    return run(relays(range, cells, j), history, subset,
               [](const model::HysteresisState& state) { return state.output; });
  };
  WeightedOperators fit = fit_weights(samples, histories(samples, range), cells, column);
  return {text_of("Preisach, ", levels, " levels"), cells + 2, std::move(fit.prediction)};
}

const std::vector<FitBaseline>& every_baseline() {
  using Parameters = model::HysteresisParameters;
  static const std::vector<FitBaseline> baselines{
      [](const Samples& samples, const Parameters& identified) {
        return fit_average(samples, identified.descending.coefficients().size() - 1);
      },
      [](const Samples& samples, const Parameters& identified) {
        return fit_linear_mapping(samples, of_one_order(identified));
      },
      [](const Samples& samples, const Parameters&) { return fit_prandtl_ishlinskii(samples, 9); },
      [](const Samples& samples, const Parameters&) { return fit_prandtl_ishlinskii(samples, 30); },
      [](const Samples& samples, const Parameters&) {
        return fit_prandtl_ishlinskii_free_start(samples, 30);
      },
      [](const Samples& samples, const Parameters&) { return fit_preisach(samples, 20); }};
  return baselines;
}

}  // namespace hystcan::identification
