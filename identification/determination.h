// How well the datasets determine the values of a trial: the error near their best values.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "identification/search.h"

namespace hystcan::identification {

struct Identified;

/// Returns the range of one k in which the RMS is within 5 % of the best, 1 / input unit. `k` is
/// k_span_ascending or k_span_descending; only this one is varied.
model::Interval pace_range(const Problem& problem, const SearchResult& found, double Trial::*k,
                           const std::function<bool()>& go_on);

/// False if the range of a k is wider than a factor of ten, or if k = 0 is also good.
bool is_determined(model::Interval pace);

/// Returns the range of the creep per decade in which the RMS error is within a tenth of the best. Each value
/// is tried with its best k and delay.
model::Interval creep_range(const Problem& problem, const SearchResult& found,
                            const std::function<bool()>& go_on);

/// An explanation instead of creep: sessions at several rates whose gains differ (another amplifier or
/// sensor) look like creep.
struct GainsInstead {
  std::vector<double> gains;  ///< gain of each dataset's output; 1 for the first dataset
  double rms = 0.0, rms_with_creep = 0.0;
};
/// Returns the best gains without creep, if their error is within a tenth of the error with the creep that
/// was found.
std::optional<GainsInstead> gains_instead_of_creep(const Problem& problem, const SearchResult& found,
                                                   const std::function<bool()>& go_on);

/// A record at a single rate hardly distinguishes the delay from the width of the loops: another delay with
/// other curves and other k fits nearly as well, but predicts faster inputs differently.
struct DelayRange {
  /// Between these delays the RMS error, with the best k for each delay, is within a tenth of the best error.
  double lo_s = 0.0, hi_s = 0.0;
  /// RMS difference between the models at both ends of the range, for the same inputs at two and five times
  /// the rate; output units.
  double at_twice_the_rate = 0.0, at_five_times_the_rate = 0.0;
};
/// Returns the range of good delays; `nullopt` if the models at its ends have no inverse. `datasets`: same as
/// in the problem. Thresholds and initial memories are the ones that the search found.
std::optional<DelayRange> delay_range(const Problem& problem, const SearchResult& found,
                                      const std::vector<Dataset>& datasets,
                                      const std::function<bool()>& go_on);

/// RMS of the best curves for each pair of k, output units. All other values are the identified ones.
struct Landscape {
  std::vector<double> k_ascending, k_descending;
  std::vector<std::vector<double>> rms;  ///< rms[i][j]: at the i-th k_descending and the j-th k_ascending
};
Landscape landscape(const std::vector<Dataset>& datasets, const Identified& identified, int points);

}  // namespace hystcan::identification
