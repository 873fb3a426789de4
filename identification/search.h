// The search for the parameters in which the output is not linear. The k of both directions are always
// searched. Initial memory, delay and thresholds beyond the observed inputs are added one by one, if this
// lowers the error, also of held-out samples. The order of the curves is the lowest one with a held-out error
// near the smallest.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identification/separable_fit.h"

namespace hystcan::identification {

/// One parameter that the search added, with the errors before and after, in output units.
struct Step {
  std::string what;  ///< "delay", "lower threshold", "initial memory"
  double rms_before = 0.0, rms_after = 0.0;
  std::optional<double> held_out_before, held_out_after;
};

struct OrderScore {
  int order = 0;
  double rms = 0.0;
  std::optional<double> held_out;
};

struct SearchOptions {
  std::optional<int> order;          ///< none: chosen by the search
  int highest_order = 20;            ///< limit of this choice
  bool observed_thresholds = false;  ///< thresholds stay at the ends of the observed inputs
  double sample_time_s = 0.0;        ///< 0: no delay is searched
  std::function<bool()> go_on;       ///< returns false: stop with the best so far
};

struct SearchResult {
  Trial trial;
  int order = 0;
  double rms = 0.0;
  std::optional<double> held_out;
  bool valid = false;
  bool one_k = false;  ///< the dataset does not distinguish k_ascending from k_descending: they are equal
  std::vector<Step> steps;
  std::vector<OrderScore> orders;
};

inline constexpr int highest_order = 20;

/// `first_inputs`: the first input of each dataset, folded.
SearchResult search(const Problem& problem, const std::vector<double>& first_inputs,
                    const SearchOptions& options);

}  // namespace hystcan::identification
