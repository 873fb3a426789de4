#include "identification/landscape.h"

#include <cmath>

#include "identification/butterfly.h"
#include "identification/excerpt.h"
#include "identification/quasi_static.h"

namespace hystcan::identification {

Landscape landscape(const std::vector<Dataset>& datasets, const Identified& identified, int points) {
  std::vector<Dataset> seen;
  seen.reserve(datasets.size());
  const std::vector<Dataset> still = identified.dynamics ? without_dynamics(datasets, identified) : datasets;
  for (const Dataset& dataset : identified.parameters.output_map ? linearised(still, identified) : still)
    seen.push_back(identified.parameters.symmetry == model::Symmetry::even ? folded(dataset) : dataset);
  Problem problem;
  problem.observed = identified.observed;
  problem.symmetry = identified.parameters.symmetry;
  problem.output_span = identified.output_span;
  for (const Dataset& dataset : seen)
    problem.excerpts.emplace_back(dataset, std::vector<int>{}, 1000,
                                  least_swing(dataset, problem.observed.span()));
  for (std::size_t i = 0; i < datasets.size(); ++i)
    problem.nuisances.push_back({identified.offsets[i] != 0.0, identified.drifts[i] != 0.0});
  problem.regressors = static_cast<Eigen::Index>(seen.front().regressors.size());
  SeparableFit fit(problem, identified.search.shape, SeparableFit::Scan::coarse);
  const double span = identified.parameters.input_range().span();
  const auto grid = [&](double best) {
    const double middle = std::asinh(best * span);
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(points));
    for (int i = 0; i < points; ++i)
      values.push_back(std::sinh(middle + 2.0 * (2.0 * i / (points - 1.0) - 1.0)) / span);
    return values;
  };
  Landscape map;
  map.k_ascending = grid(identified.parameters.k_ascending);
  map.k_descending = grid(identified.parameters.k_descending);
  Trial trial = identified.search.trial;
  for (const double descending : map.k_descending) {
    map.rms.emplace_back();
    for (const double ascending : map.k_ascending) {
      trial.k_span_ascending = ascending * span;
      trial.k_span_descending = descending * span;
      map.rms.back().push_back(fit.fit(trial).rms);
    }
  }
  return map;
}

}  // namespace hystcan::identification
