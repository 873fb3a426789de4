// How well the datasets determine the numbers of a trial: the error beside their best values.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "identification/search.h"

namespace hystcan::identification {

struct Identified;

/// The range of one k in which the RMS is within 5 % of the best, 1 / input unit. `k`: k_span_ascending or
/// k_span_descending, which is moved alone.
model::Interval pace_range(const Problem& problem, const SearchResult& found, double Trial::*k,
                           const std::function<bool()>& go_on);

/// False: the range of a k is wider than a factor of ten, or k = 0 is also good.
bool is_determined(model::Interval pace);

/// The creep per decade with which the RMS error is within a tenth of the best, with the best k and delay for
/// each.
model::Interval creep_range(const Problem& problem, const SearchResult& found,
                            const std::function<bool()>& go_on);

/// Sessions at several rates whose gains differ (another amplifier or sensor) look like creep.
struct GainsInstead {
  std::vector<double> gains;  ///< of each dataset's output; that of the first is 1
  double rms = 0.0, rms_with_creep = 0.0;
};
/// The best gains without creep, if their error is within a tenth of the error with the creep found.
std::optional<GainsInstead> gains_instead_of_creep(const Problem& problem, const SearchResult& found,
                                                   const std::function<bool()>& go_on);

/// A record at one rate hardly tells the delay from the width of the loops: with another delay, other curves
/// and other k do nearly as well, but predict faster inputs differently.
struct DelayRange {
  double lo_s = 0.0,
         hi_s = 0.0;  ///< the RMS error is within a tenth of the best, with the best k for each delay
  /// RMS difference between the models of both ends for the same inputs, two and five times as fast; output
  /// units
  double at_twice_the_rate = 0.0, at_five_times_the_rate = 0.0;
};
/// None if the models of its ends have no inverse. `datasets`: as in the problem. Thresholds and initial
/// memories are those that the search found.
std::optional<DelayRange> delay_range(const Problem& problem, const SearchResult& found,
                                      const std::vector<Dataset>& datasets,
                                      const std::function<bool()>& go_on);

/// RMS of the best curves for each pair of k, output units. All other values are as identified.
struct Landscape {
  std::vector<double> k_ascending, k_descending;
  std::vector<std::vector<double>> rms;  ///< [descending][ascending]
};
Landscape landscape(const std::vector<Dataset>& datasets, const Identified& identified, int points);

}  // namespace hystcan::identification
