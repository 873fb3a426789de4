// Computes how well the datasets determine the parameters of the best model (convergence rates, creep,
// delay): how far each of them can move before the error grows.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "identification/search.h"

namespace hystcan::identification {

struct Identified;

/// Returns the range of one convergence rate (k_ascending or k_descending), in 1/input unit, in which the RMS
/// error of the fit is at most 5 % larger than at the best rate. `k` selects the rate: it is
/// &Trial::k_span_ascending or &Trial::k_span_descending. For each tried rate, the curves are fitted again;
/// everything else in found.trial stays constant (the other rate, thresholds, delay, creep, memories, gains).
model::Interval pace_range(const Problem& problem, const SearchResult& found, double Trial::*k,
                           const std::function<bool()>& go_on);

/// Returns true if the datasets determine a convergence rate well enough. `pace`: the range of this rate from
/// pace_range(). The range must not contain 0, and its ends must differ by less than a factor of ten.
bool is_determined(model::Interval pace);

/// Returns the range of the creep per decade in which the RMS error of the fit is at most 10 % larger than
/// with the creep in found.trial. For each tried creep, the convergence rates and the delay get their best
/// values.
model::Interval creep_range(const Problem& problem, const SearchResult& found,
                            const std::function<bool()>& go_on);

/// Gains of the datasets that explain the outputs as well as creep does. Creep makes the output of a slow
/// dataset larger than that of a fast one. If the datasets have different speeds, a different gain of each
/// dataset (another amplifier or sensor) has the same effect.
struct GainsInstead {
  std::vector<double> gains;  ///< gain of each dataset's output, relative to the first dataset
  double rms = 0.0, rms_with_creep = 0.0;
};
/// Returns the best gains without creep. Returns `nullopt` if their error is more than a tenth larger than
/// the error with the creep that was found.
std::optional<GainsInstead> gains_instead_of_creep(const Problem& problem, const SearchResult& found,
                                                   const std::function<bool()>& go_on);

/// The delays that fit nearly as well as the best delay. A record at a single rate hardly distinguishes the
/// delay from the width of the loops: with another delay, other curves and other convergence rates fit nearly
/// as well. But such a model predicts faster inputs differently.
struct DelayRange {
  /// Shortest and longest delay for which the RMS error of the fit is at most 10 % larger than with the best
  /// delay. For each tried delay, both convergence rates get their best values.
  double lo_s = 0.0, hi_s = 0.0;
  /// RMS difference between the model with the shortest delay and the model with the longest delay, output
  /// units. The inputs are those of the datasets, played two or five times as fast.
  double at_twice_the_rate = 0.0, at_five_times_the_rate = 0.0;
};
/// Returns the range of the delays that fit nearly as well as the best delay. `datasets` must be the datasets
/// of the problem. Thresholds and initial memories are those that the search found. Returns `nullopt` if the
/// models at the ends of the range have no inverse, or if `go_on` stopped the computation.
std::optional<DelayRange> delay_range(const Problem& problem, const SearchResult& found,
                                      const std::vector<Dataset>& datasets,
                                      const std::function<bool()>& go_on);

/// A map of the error: the RMS error of the best curves for each pair of convergence rates k, in output
/// units. All other values are the identified ones.
struct Landscape {
  std::vector<double> k_ascending, k_descending;
  /// RMS error with k_descending[i] and k_ascending[j], at the place [i][j].
  std::vector<std::vector<double>> rms;
};
Landscape landscape(const std::vector<Dataset>& datasets, const Identified& identified, int points);

}  // namespace hystcan::identification
