// The search for what the output is not linear in: k of both directions, always; and what the dataset asks
// for: initial memory, delay, thresholds beyond the observed inputs. Each is taken in where it lowers the
// error, held-out samples' too; the order of the curves is the lowest that held-out samples are content with.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identification/separable_fit.h"

namespace hystcan::identification {

/// One thing that was taken in, and what it did; errors in output units.
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
  std::optional<int> order;          ///< none: chosen, up to
  int highest_order = 20;            ///< this one
  bool observed_thresholds = false;  ///< thresholds stay at the ends of the observed inputs
  double sample_time_s = 0.0;        ///< 0: no delay is looked for
  std::function<bool()> go_on;       ///< false: stop with the best so far
};

struct SearchResult {
  Trial trial;
  int order = 0;
  double rms = 0.0;
  std::optional<double> held_out;
  bool valid = false;
  bool one_k = false;  ///< the dataset can't tell k_ascending from k_descending: they are the same
  std::vector<Step> steps;
  std::vector<OrderScore> orders;
};

inline constexpr int highest_order = 20;

/// `first_inputs`: of each dataset, folded.
SearchResult search(const Problem& problem, const std::vector<double>& first_inputs,
                    const SearchOptions& options);

}  // namespace hystcan::identification
