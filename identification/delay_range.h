// How well a delay is determined. A record at one rate hardly tells it from the width of the loops: with another
// delay, other curves and other k do nearly as well, but predict faster inputs differently.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "identification/dataset.h"
#include "identification/search.h"

namespace hystcan::identification {

struct DelayRange {
  double lo_s = 0.0,
         hi_s = 0.0;  ///< the RMS error is within a tenth of the best, with the best k for each delay
  /// RMS difference between the models of both ends for the same inputs, two and five times as fast; output units
  double at_twice_the_rate = 0.0, at_five_times_the_rate = 0.0;
};

/// None if the models of its ends have no inverse. `datasets`: as in the problem. Thresholds and initial memories are those that the search found.
std::optional<DelayRange> delay_range(const Problem& problem, const SearchResult& found,
                                      const std::vector<Dataset>& datasets,
                                      const std::function<bool()>& go_on);

}  // namespace hystcan::identification
