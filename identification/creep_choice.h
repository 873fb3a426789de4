// Whether a model has creep. What a search takes in next depends on whether it has taken in creep: at one rate, a delay, a
// wider loop and another past make up for it. So both ways are gone to their end, and what is held out decides.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "identification/search.h"
#include "identification/valley.h"

namespace hystcan::identification {

struct CreepChoice {
  SearchResult found;
  std::optional<SearchResult> other;  ///< the one that was not taken; none: creep was given, or was of no use
};

/// As search().
CreepChoice choose_creep(const Problem& problem, const std::vector<double>& first_inputs,
                         const SearchOptions& options);

/// The creep per decade with which the RMS error is within a tenth of the best, with the best k and delay for each.
ValueRange creep_range(const Problem& problem, const SearchResult& found, const std::function<bool()>& go_on);

}  // namespace hystcan::identification
