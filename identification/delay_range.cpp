#include "identification/delay_range.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identification/prediction.h"
#include "identification/valley.h"

namespace hystcan::identification {

std::optional<DelayRange> delay_range(const Problem& problem, const SearchResult& found,
                                      const std::vector<Dataset>& datasets,
                                      const std::function<bool()>& go_on) {
  double shortest_s = std::numeric_limits<double>::infinity();
  for (const Dataset& dataset : datasets)
    shortest_s = std::min(shortest_s, (dataset.time_s.back() - dataset.time_s.front()) /
                                          static_cast<double>(dataset.size() - 1));
  Valley valley(
      problem, found, &Trial::delay_s, [](const Trial&) { return std::vector<Unknown>{}; }, go_on);
  const double step_s = std::max(0.1 * shortest_s, 0.05 * found.trial.delay_s);
  const Trial low = valley.farthest(-step_s), high = valley.farthest(step_s);
  SeparableFit fine(problem, found.shape, SeparableFit::Scan::fine);
  const Fitted of_low = fine.fit(low), of_high = fine.fit(high);
  if (!of_low.valid || !of_high.valid) return std::nullopt;
  const auto first = model::Hysteresis::beyond_limit(of_low.parameters);
  const auto last = model::Hysteresis::beyond_limit(of_high.parameters);
  const auto difference = [&](double faster) {
    double square = 0.0, samples = 0.0;
    for (std::size_t i = 0; i < datasets.size() && go_on(); ++i) {
      Dataset fast = datasets[i];
      for (double& t : fast.time_s) t /= faster;
      const auto a = predict(first, fast, {low.delay_s, {}, creep_of(found.trial.creep_per_decade)},
                             found.trial.memories[i]);
      const auto b = predict(last, fast, {high.delay_s, {}, creep_of(found.trial.creep_per_decade)},
                             found.trial.memories[i]);
      const ErrorNorms norms = ErrorNorms::of(a, b);
      square += norms.rms * norms.rms * static_cast<double>(a.size());
      samples += static_cast<double>(a.size());
    }
    return std::sqrt(square / samples);
  };
  const DelayRange range{low.delay_s, high.delay_s, difference(2.0), difference(5.0)};
  return go_on() ? std::optional(range) : std::nullopt;
}

}  // namespace hystcan::identification
