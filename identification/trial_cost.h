// What a trial costs in a search.
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
  /// `options.go_on` is not empty.
  TrialCost(const Problem& problem, const IdentifyOptions& options) : problem_(problem), options_(options) {}
  /// Begins a new fit. A fit keeps the inequalities that it has met (valid_curves.h), and the last digits of
  /// later results depend on them.
  void use(const CurveShape& shape);

  /// RMS error of the best curves, output units, with a surcharge if they are not valid. Perhaps infinite if
  /// it is not below `limit`; infinite if the options or the criteria exclude the trial.
  double operator()(const Trial& trial, double limit = infinite_cost);

  /// k times the span that are worth a try: these, and larger ones on steep curves.
  std::vector<double> paces(std::vector<double> k_spans) const;

  const Problem& problem() const { return problem_; }
  const IdentifyOptions& options() const { return options_; }
  bool go_on() const { return options_.go_on(); }
  /// With the curves of the shape in use.
  SeparableFit& fit() { return *fit_; }

 private:
  const Problem& problem_;
  const IdentifyOptions& options_;
  std::optional<SeparableFit> fit_;
  double steepness_ =
      1.0;  ///< where nearly all of the output happens in a small part of the inputs, loops are
            ///< as small as that part
};

}  // namespace hystcan::identification
