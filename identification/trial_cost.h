// The cost of a trial in a search.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "identification/search.h"
#include "identification/separable_fit.h"

namespace hystcan::identification {

inline constexpr double infinite_cost = std::numeric_limits<double>::infinity();

class TrialCost {
 public:
  /// `options.go_on` must not be empty.
  TrialCost(const Problem& problem, const IdentifyOptions& options) : problem_(problem), options_(options) {}
  /// Begins a new fit. A fit keeps the inequalities that were active (valid_curves.h), and the last digits of
  /// later results depend on them.
  void use(const CurveShape& shape);

  /// Returns the RMS error of the best curves, output units, with a surcharge if they are not valid. May
  /// return infinity if the error is not below `limit`; returns infinity if the options or the criteria
  /// exclude the trial.
  double operator()(const Trial& trial, double limit = infinite_cost);

  /// Returns the values of k times span to try: the given ones, and larger ones for steep curves.
  std::vector<double> paces(std::vector<double> k_spans) const;

  const Problem& problem() const { return problem_; }
  const IdentifyOptions& options() const { return options_; }
  bool go_on() const { return options_.go_on(); }
  /// Returns the fit with the shape in use.
  SeparableFit& fit() { return *fit_; }

 private:
  const Problem& problem_;
  const IdentifyOptions& options_;
  std::optional<SeparableFit> fit_;
  /// > 1 if nearly all of the output changes in a small part of the inputs: loops are then as small as this
  /// part.
  double steepness_ = 1.0;
};

}  // namespace hystcan::identification
