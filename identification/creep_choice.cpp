#include "identification/creep_choice.h"

#include <algorithm>
#include <utility>

namespace hystcan::identification {
namespace {

constexpr double worth_creep = 0.97;  // of the score without it

double score_of(const SearchResult& result) { return score(result.rms, result.held_out, result.shape); }

}  // namespace

CreepChoice choose_creep(const Problem& problem, const std::vector<double>& first_inputs,
                         const SearchOptions& options) {
  CreepChoice choice{search(problem, first_inputs, options), {}};
  if (options.creep_per_decade || choice.found.trial.creep_per_decade == 0.0 || !options.go_on())
    return choice;
  SearchOptions none = options;
  none.creep_per_decade = 0.0;
  choice.other = search(problem, first_inputs, none);
  if (options.go_on() && score_of(choice.found) > worth_creep * score_of(*choice.other))
    std::swap(choice.found, *choice.other);
  return choice;
}

ValueRange creep_range(const Problem& problem, const SearchResult& found,
                       const std::function<bool()>& go_on) {
  const double best = found.trial.creep_per_decade;
  const Valley::Companions delay = [](const Trial& trial) {
    return trial.delay_s > 0.0 ? std::vector{delay_of(trial, trial.delay_s)} : std::vector<Unknown>{};
  };
  Valley valley(problem, found, &Trial::creep_per_decade, delay, go_on);
  const double step = 0.1 * best;
  return {valley.farthest(-step).creep_per_decade, valley.farthest(step).creep_per_decade};
}

}  // namespace hystcan::identification
