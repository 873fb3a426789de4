// The search for the parameters in which the output is not linear. The k of both directions are always
// searched. Initial memory, delay, creep, gains of datasets and thresholds beyond the observed inputs are added one by one, if this
// lowers the error, also of held-out samples. The order of the curves is the lowest one with a held-out error
// near the smallest. Splines take the place of polynomials if held-out errors are clearly smaller with them.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "identification/separable_fit.h"

namespace hystcan::identification {

/// One parameter that the search added, with the errors before and after, in output units.
struct Step {
  std::string what;  ///< "delay", "creep", "lower threshold", "initial memory", "gain"
  double rms_before = 0.0, rms_after = 0.0;
  std::optional<double> held_out_before, held_out_after;
};

struct ShapeScore {
  CurveShape shape;
  double rms = 0.0;
  std::optional<double> held_out;
};

enum class CurveChoice { automatic, polynomial, spline };
constexpr auto words(CurveChoice) {
  return std::to_array<std::string_view>({"auto", "polynomial", "spline"});
}

struct SearchOptions {
  CurveChoice curves = CurveChoice::automatic;
  std::optional<CurveShape> shape;         ///< none: chosen by the search
  int highest_order = 20;                  ///< limit of this choice
  bool observed_thresholds = false;        ///< thresholds stay at the ends of the observed inputs
  bool own_gains = false;                  ///< each dataset but the first can have a gain
  double sample_time_s = 0.0;              ///< 0: no delay is searched
  std::optional<double> delay_s;           ///< known; none: searched
  std::optional<double> creep_per_decade;  ///< known; none: searched
  double longest_delay_s = std::numeric_limits<double>::infinity();
  std::function<std::vector<double>(int)> knots;  ///< of a spline with this number of pieces
  int most_pieces = 0;                            ///< 0: no splines
  const Problem* finer = nullptr;                 ///< more samples, for the last steps; none: the same
  std::function<bool()> go_on;                    ///< returns false: stop with the best so far
};

struct SearchResult {
  Trial trial;
  CurveShape shape;
  double rms = 0.0;
  std::optional<double> held_out;
  bool valid = false;
  bool one_k = false;  ///< the dataset does not distinguish k_ascending from k_descending: they are equal
  std::vector<Step> steps;
  std::vector<Step> refused;       ///< lower the error, but not that of what is held out
  std::vector<ShapeScore> shapes;  ///< tried: polynomials, then splines; empty: the shape was given
};

inline constexpr int highest_order = 20;

/// By which models are compared: the held-out error; without one, the error, where each coefficient must pay for itself.
inline double score(double rms, const std::optional<double>& held_out, const CurveShape& shape) {
  return held_out.value_or(rms * (1.0 + 0.02 * (shape.coefficients() - 1)));
}

/// `first_inputs`: the first input of each dataset, folded. Throws std::invalid_argument if no trial has a finite error.
SearchResult search(const Problem& problem, const std::vector<double>& first_inputs,
                    const SearchOptions& options);

}  // namespace hystcan::identification
