// Searches for those parameters of a model on which the output depends nonlinearly.
//
// The convergence rates k_ascending and k_descending (for rising and falling branches) are always searched.
// Other unknowns are added one by one: initial memory, delay, creep, one gain per dataset, and thresholds
// beyond the observed inputs. An unknown is added only if it lowers the error, and also the error of held-out
// samples. The order of the curves is the lowest order whose held-out error is close to the smallest one.
// Splines replace polynomials if their held-out error is clearly smaller.
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

/// One unknown that the search added, with the errors before and after it was added, in output units.
struct Step {
  Quantity quantity;
  double rms_before = 0.0, rms_after = 0.0;
  std::optional<double> held_out_before, held_out_after;
};

/// A shape of the reference curves, with its errors in output units. `held_out` is `nullopt` if nothing was
/// held out.
struct ShapeScore {
  CurveShape shape;
  double rms = 0.0;
  std::optional<double> held_out;

  /// Returns the number by which models are compared; the smaller one is better. It is the held-out error. If
  /// nothing was held out, it is the error, increased by 2 % for each coefficient after the first.
  double score() const { return held_out.value_or(rms * (1.0 + 0.02 * (shape.coefficients() - 1))); }
};

enum class CurveChoice { automatic, polynomial, spline };
constexpr auto words(CurveChoice) {
  return std::to_array<std::string_view>({"auto", "polynomial", "spline"});
}

/// The kind of output: `none` for no symmetry, `even` for x(v) = x(-v) (x: output, v: input), or a butterfly
/// with an output map. `automatic` decides this from the dataset. If the output falls and rises again while
/// the input moves in one direction, the search tries a butterfly and compares the held-out errors.
enum class ShapeOfOutput { automatic, none, even, butterfly };
constexpr auto words(ShapeOfOutput) {
  return std::to_array<std::string_view>({"auto", "none", "even", "butterfly"});
}

struct IdentifyOptions {
  CurveChoice curves = CurveChoice::automatic;
  /// Shape of the reference curves; `nullopt`: the search selects the shape by the held-out error.
  std::optional<CurveShape> shape;
  ShapeOfOutput output = ShapeOfOutput::automatic;
  /// True: the thresholds are the ends of the observed input range.
  bool observed_thresholds = false;
  /// True: all datasets have the same zero, so that their outputs have no offsets.
  bool common_zero = false;
  /// True: all datasets have the same gain.
  bool common_gain = false;
  bool drift = false;             ///< true: each dataset has its own linear drift
  std::optional<double> delay_s;  ///< known delay; `nullopt`: the delay is searched
  std::optional<double> longest_delay_s;
  /// Known creep, 0 for none; `nullopt`: the creep is searched.
  std::optional<double> creep_per_decade;
  /// Number of samples in the search; the last fit uses all samples.
  std::size_t search_samples = 3000;
  /// Called during the search. If it returns false, the search stops with the best result so far. Empty:
  /// never stops.
  std::function<bool()> go_on;
  /// For each dataset, a flag for each sample. If it is true, the fit does not use the output of the sample.
  /// It still uses the input, because the hysteresis remembers every input. Empty: the fit uses all samples.
  std::vector<std::vector<bool>> unseen;
  /// Number of datasets, at the end of the list, that are part of every fit and are never held out to test a
  /// model. Example: the loops of an old model, which are not measurements.
  std::size_t never_held_out = 0;
};

struct SearchResult : ShapeScore {
  Trial trial;
  /// True: rising and falling branches have the same convergence rate (k_ascending = k_descending), because
  /// the datasets are not sufficient to distinguish two rates.
  bool one_k = false;
  std::vector<Step> steps;
  /// Unknowns that lower the error, but not the held-out error; they were not added.
  std::vector<Step> refused;
  /// All shapes that were tried: polynomials, then splines; empty if the shape was given.
  std::vector<ShapeScore> shapes;
};

/// Searches for the model with the smallest error. `finer` is the same problem with more samples; the search
/// uses it to refine all unknowns at the end. `options.go_on` must not be empty. Throws std::invalid_argument
/// if no trial has a finite error.
SearchResult search(const Problem& problem, const Problem& finer, const IdentifyOptions& options);

}  // namespace hystcan::identification
