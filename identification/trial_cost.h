// The cost that a search minimises: the error of the best model for a trial, with a surcharge for invalid
// models.
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
  /// `options.go_on` must contain a function. `problem` and `options` must exist as long as the object.
  TrialCost(const Problem& problem, const IdentifyOptions& options) : problem_(problem), options_(options) {}
  /// Begins to fit curves of another shape. Discards the inequalities that were active in former fits
  /// (valid_curves.h). With them, the last digits of a result would depend on these former fits.
  void use(const CurveShape& shape);

  /// Returns the cost of a trial: the RMS error of its best curves, output units, with a surcharge if they
  /// are not valid. Returns infinity if the options or the criteria do not allow the trial. If the error is
  /// not below `limit`, the result may also be infinity.
  double operator()(const Trial& trial, double limit = infinite_cost);

  /// Returns the start values of a search for k times the distance of the thresholds (k: convergence rate).
  /// These are the values `k_spans`, and also larger values if the curves are steep.
  std::vector<double> paces(std::vector<double> k_spans) const;

  const Problem& problem() const { return problem_; }
  const IdentifyOptions& options() const { return options_; }
  bool go_on() const { return options_.go_on(); }
  /// Returns the fit for the shape that the last call of use() set.
  SeparableFit& fit() { return *fit_; }

 private:
  const Problem& problem_;
  const IdentifyOptions& options_;
  std::optional<SeparableFit> fit_;
  /// Factor by which the convergence rate k may exceed its usual maximum (SearchCriteria::widest_k_span). It
  /// is greater than 1 if a piece of the spline is short, because the output is steep there: a loop inside
  /// this piece needs a large k.
  double steepness_ = 1.0;
};

}  // namespace hystcan::identification
