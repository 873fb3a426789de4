// The search for the parameters in which the output is not linear. The k of both directions are always
// searched. Initial memory, delay, creep, gains of datasets and thresholds beyond the observed inputs are
// added one by one, if this lowers the error, also of held-out samples. The order of the curves is the lowest
// one with a held-out error near the smallest. Splines take the place of polynomials if held-out errors are
// clearly smaller with them.
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

  /// By which models are compared: the held-out error; without one, the error, where each coefficient must
  /// pay for itself.
  double score() const { return held_out.value_or(rms * (1.0 + 0.02 * (shape.coefficients() - 1))); }
};

enum class CurveChoice { automatic, polynomial, spline };
constexpr auto words(CurveChoice) {
  return std::to_array<std::string_view>({"auto", "polynomial", "spline"});
}

/// Of the model: a symmetry, or a butterfly with an output map. automatic: determined from the dataset, the
/// butterfly by hold-out where the output passes a valley inside a swing of the input.
enum class ShapeOfOutput { automatic, none, even, butterfly };
constexpr auto words(ShapeOfOutput) {
  return std::to_array<std::string_view>({"auto", "none", "even", "butterfly"});
}

struct IdentifyOptions {
  CurveChoice curves = CurveChoice::automatic;
  std::optional<CurveShape> shape;  ///< of the reference curves; none: chosen by hold-out
  ShapeOfOutput output = ShapeOfOutput::automatic;
  bool observed_thresholds = false;  ///< thresholds at the ends of the observed input range
  bool common_zero = false;          ///< several datasets: no offsets between them
  bool common_gain = false;          ///< several datasets: no gains between them
  bool drift = false;                ///< each dataset has a linear drift of its own
  std::optional<double> delay_s;     ///< known; none: searched
  std::optional<double> longest_delay_s;
  std::optional<double> creep_per_decade;  ///< known, 0: none; none: searched
  std::size_t search_samples = 3000;       ///< samples that the search uses; the last fit uses all
  std::function<bool()> go_on;             ///< returns false: stop with the best so far; none: never stop
  /// A flag for each sample, per dataset. The fit does not use the output of an unseen sample, but it applies
  /// its input. Empty: no sample is unseen.
  std::vector<std::vector<bool>> unseen;
  std::size_t never_held_out = 0;  ///< the last ones of the datasets
};

struct SearchResult : ShapeScore {
  Trial trial;
  bool one_k = false;  ///< the dataset does not distinguish k_ascending from k_descending: they are equal
  std::vector<Step> steps;
  std::vector<Step> refused;       ///< lower the error, but not that of what is held out
  std::vector<ShapeScore> shapes;  ///< tried: polynomials, then splines; empty: the shape was given
};

/// `finer`: the same problem with more samples, for the last steps. `options.go_on` is not empty.
/// Throws std::invalid_argument if no trial has a finite error.
SearchResult search(const Problem& problem, const Problem& finer, const IdentifyOptions& options);

}  // namespace hystcan::identification
