#include "identification/trial_cost.h"

#include <algorithm>
#include <cmath>

#include "identification/search_criteria.h"

namespace hystcan::identification {

void TrialCost::use(const CurveShape& shape) {
  fit_.emplace(problem_, shape, SeparableFit::coarse_scan);
  double narrowest = problem_.observed.span();
  for (std::size_t i = 1; i < shape.knots.size(); ++i)
    narrowest = std::min(narrowest, shape.knots[i] - shape.knots[i - 1]);
  steepness_ = std::max(1.0, criteria.steep_part * problem_.observed.span() / narrowest);
}

double TrialCost::operator()(const Trial& trial, double limit) {
  const auto is_beyond = [](double value, double most) { return value < 0.0 || value > most; };
  const auto [least_k, most_k] = std::minmax(trial.k_span_ascending, trial.k_span_descending);
  if (is_beyond(trial.below, criteria.farthest_threshold) ||
      is_beyond(trial.above, criteria.farthest_threshold) ||
      is_beyond(trial.delay_s, options_.longest_delay_s.value_or(infinite_cost)) ||
      is_beyond(trial.creep_per_decade, most_creep_per_decade) || least_k < -criteria.widest_k_span ||
      most_k > criteria.widest_k_span * steepness_)
    return infinite_cost;
  const Fitted fitted = fit_->fit(trial, limit);
  if (fitted.valid || !std::isfinite(fitted.rms)) return fitted.rms;
  return fitted.rms * (1.01 + 2.0 * fitted.violation) +
         1e-4 * problem_.output_span * (1.0 + fitted.violation);
}

std::vector<double> TrialCost::paces(std::vector<double> k_spans) const {
  const double largest = k_spans.back() * steepness_;
  while (3.0 * k_spans.back() <= largest) k_spans.push_back(3.0 * k_spans.back());
  return k_spans;
}

}  // namespace hystcan::identification
