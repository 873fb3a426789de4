// Separable least squares (variable projection): for each choice of what the output is not linear in, the
// best reference curves are one linear problem (regression.h); only the few numbers of a Trial are searched.
//
// G. Golub, V. Pereyra, "Separable nonlinear least squares", Inverse Problems 19, 2003.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "identification/excerpt.h"
#include "identification/initial_memory.h"
#include "identification/regression.h"
#include "identification/valid_curves.h"

namespace hystcan::identification {

struct Trial {
  double k_span_ascending = 1.0;  ///< k times the span of the thresholds
  double k_span_descending = 1.0;
  double below = 0.0;  ///< lower threshold below the lowest input, in observed input spans
  double above = 0.0;  ///< upper threshold above the highest one
  double delay_s = 0.0;
  std::vector<InitialMemory> memories;  ///< of each dataset
};

/// What a fit is made for; the same for all trials.
struct Problem {
  std::vector<Excerpt> excerpts;
  int folds = 1;
  model::Interval observed;  ///< inputs that occur, folded
  model::Symmetry symmetry = model::Symmetry::none;
  double output_span = 1.0;

  model::Interval thresholds(const Trial& trial) const;
};

struct Fitted {
  model::HysteresisParameters parameters;  ///< no units
  double rms = 0.0;                        ///< output units, over what the excerpts hold
  bool valid = false;                      ///< curves and branches increase: it has an inverse
  double wrong = 0.0;                      ///< where not: how far from it (valid_curves.h)
};

class SeparableFit {
 public:
  /// How closely the branches are looked at; what is kept is to be looked at as closely as when loaded.
  enum class Scan : std::size_t { coarse = 50, fine = 200 };
  SeparableFit(const Problem& problem, int order, Scan scan);

  /// The best curves that make an invertible model (valid_curves.h) at the trial's k.
  Fitted fit(const Trial& trial);

  /// Root mean square of what the samples of each fold but fold 0 are missed by, fitted without that fold.
  /// None where the others hold no sample.
  std::optional<double> held_out(const Trial& trial);

 private:
  std::vector<NormalEquations> systems(const Trial& trial);
  void prepare(const Trial& trial);
  ValidCurves::Solution solve(const NormalEquations& system, const Trial& trial);

  const Problem& problem_;
  int order_;
  ValidCurves curves_;
  std::vector<Regression> regressions_;  // of the trial last seen, whatever its k
  std::optional<Trial> prepared_;
};

}  // namespace hystcan::identification
