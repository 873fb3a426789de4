// Searches for the parameters in which the output is not linear. k_ascending and k_descending are always
// searched. Initial memory, delay, creep, one gain per dataset and thresholds beyond the observed inputs are
// added one by one if this lowers the error, also for held-out samples. Of all orders of the curves, the
// lowest one is chosen whose held-out error is close to the smallest held-out error. Splines replace
// polynomials if their held-out errors are clearly smaller.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "identification/quantity.h"
#include "identification/separable_fit.h"

namespace hystcan::identification {

/// One parameter that the search added, with the errors before and after, in output units.
struct Step {
  Quantity quantity;
  double rms_before = 0.0, rms_after = 0.0;
  std::optional<double> held_out_before, held_out_after;
};

/// A shape of the curves with its errors, in output units.
struct ShapeScore {
  CurveShape shape;
  double rms = 0.0;
  std::optional<double> held_out;

  /// Returns the score by which models are compared: the held-out error. If nothing was held out: the error,
  /// increased with the number of coefficients.
  double score() const { return held_out.value_or(rms * (1.0 + 0.02 * (shape.coefficients() - 1))); }
};

enum class CurveChoice { automatic, polynomial, spline };
constexpr auto words(CurveChoice) {
  return std::to_array<std::string_view>({"auto", "polynomial", "spline"});
}

/// The shape of the output: a symmetry, or a butterfly with an output map. `automatic` derives it from the
/// dataset; it tries the butterfly by hold-out if the output passes a valley inside a swing of the input.
enum class ShapeOfOutput { automatic, none, even, butterfly };
constexpr auto words(ShapeOfOutput) {
  return std::to_array<std::string_view>({"auto", "none", "even", "butterfly"});
}

struct IdentifyOptions {
  CurveChoice curves = CurveChoice::automatic;
  std::optional<CurveShape> shape;  ///< shape of the reference curves; `nullopt`: chosen by hold-out
  ShapeOfOutput output = ShapeOfOutput::automatic;
  bool observed_thresholds = false;  ///< thresholds at the ends of the observed input range
  bool common_zero = false;          ///< several datasets: no offsets between them
  bool common_gain = false;          ///< several datasets: no gains between them
  bool drift = false;                ///< each dataset has its own linear drift
  std::optional<double> delay_s;     ///< known delay; `nullopt`: searched
  std::optional<double> longest_delay_s;
  std::optional<double> creep_per_decade;  ///< known creep, 0 for none; `nullopt`: searched
  std::size_t search_samples = 3000;       ///< samples that the search uses; the last fit uses all
  /// Returns false to stop with the best result so far; empty: never stops.
  std::function<bool()> go_on;
  /// A flag for each sample, per dataset. The fit does not use the output of an unseen sample, but it applies
  /// its input. Empty: no sample is unseen.
  std::vector<std::vector<bool>> unseen;
  std::size_t never_held_out = 0;  ///< number of last datasets that are never held out
};

struct SearchResult : ShapeScore {
  Trial trial;
  bool one_k = false;  ///< the dataset does not distinguish k_ascending from k_descending: they are equal
  std::vector<Step> steps;
  std::vector<Step> refused;       ///< steps that lower the error, but not the held-out error
  std::vector<ShapeScore> shapes;  ///< tried shapes: polynomials, then splines; empty: the shape was given
};

/// `finer`: the same problem with more samples, for the last steps. `options.go_on` must not be empty. Throws
/// std::invalid_argument if no trial has a finite error.
SearchResult search(const Problem& problem, const Problem& finer, const IdentifyOptions& options);

}  // namespace hystcan::identification
