// Fits a model by separable least squares (variable projection). The search varies only the few numbers of a
// Trial, on which the output depends nonlinearly. For each Trial, the best reference curves are the solution
// of one linear problem (regression.h).
//
// G. Golub, V. Pereyra, "Separable nonlinear least squares", Inverse Problems 19, 2003.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "identification/excerpt.h"
#include "identification/prediction.h"
#include "identification/regression.h"
#include "identification/valid_curves.h"

namespace hystcan::identification {

struct Trial {
  double k_span_ascending = 1.0;  ///< convergence rate k times the distance of the thresholds
  double k_span_descending = 1.0;
  /// Distance of the lower threshold below the lowest input, in spans of the observed inputs.
  double below = 0.0;
  /// Distance of the upper threshold above the highest input, in spans of the observed inputs.
  double above = 0.0;
  double delay_s = 0.0;
  /// Creep per decade of time, as a share of the output (model/output_creep.h).
  double creep_per_decade = 0.0;
  std::vector<InitialMemory> memories;  ///< memory at the beginning of each dataset
  /// Gain of each dataset's output, relative to the model; empty: all gains are 1.
  std::vector<double> gains;

  double gain(std::size_t dataset) const { return gains.empty() ? 1.0 : gains[dataset]; }
};

/// Maximum creep per decade in a search. The search uses the default time constants of model/output_creep.h.
/// For them, the limit in that file is 1/6: half of the output then arrives late.
inline constexpr double most_creep_per_decade = 0.16;
/// Returns a creep with the default time constants of model/output_creep.h; `nullopt` if `per_decade` is 0.
std::optional<model::OutputCreep::Config> creep_of(double per_decade);

inline constexpr int highest_order = 20;

/// The data and limits of a fit that are the same for all trials.
struct Problem {
  std::vector<Excerpt> excerpts;
  /// Unknowns of each dataset (offset, drift); empty: none.
  std::vector<Nuisances> nuisances;
  Eigen::Index regressors = 0;  ///< number of regressors in each dataset
  int folds = 1;
  /// True: each fold contains samples of a single dataset (records_as_folds()). Fold 0 is the exception: it
  /// contains all samples that are never held out, from all datasets.
  bool whole_excerpts = false;
  model::Interval observed;  ///< range of all inputs; of their magnitudes if symmetry is even
  model::Symmetry symmetry = model::Symmetry::none;
  double output_span = 1.0;
  // The maximum order of a polynomial and the maximum number of pieces of a spline. Both are smaller if there
  // are few samples, because few samples cannot determine many coefficients.
  int highest_order = identification::highest_order;
  int most_pieces = 0;  ///< maximum number of pieces of a spline; 0: no splines
  /// Returns the knots of a spline; the argument is the number of its pieces.
  std::function<std::vector<double>(int)> knots;
  double sample_time_s = 0.0;  ///< time between two samples; 0: do not search a delay

  model::Interval thresholds(const Trial& trial) const;
};

struct Fitted {
  model::HysteresisParameters parameters;  ///< parameters of the model; the units are empty
  /// RMS error over all samples that the fit used, output units; may be infinite.
  double rms = 0.0;
  /// True if all curves and branches increase, so that the model has an inverse.
  bool valid = false;
  /// 0 if the model is valid; otherwise how much it violates the conditions in valid_curves.h.
  double violation = 0.0;
  /// Offset and drift of each dataset, output units; 0 if not fitted.
  std::vector<double> offsets, drifts;
};

/// How well the samples of one fold are predicted by a fit to the other folds.
struct LeftOut {
  double square = 0.0;  ///< sum of squared errors in this fold
  double samples = 0.0;
  /// Slope of the measured over the predicted outputs: 1 if the prediction has the right size. Offsets do not
  /// count.
  double gain = 1.0;

  double rms() const { return samples > 0.0 ? std::sqrt(square / samples) : 0.0; }
};

class SeparableFit {
 public:
  /// Number of grid steps in a check of the branches. The search uses `coarse_scan`. The final model is
  /// checked with `fine_scan`, like every model that is read from a file.
  static constexpr std::size_t coarse_scan = 50, fine_scan = 200;
  SeparableFit(const Problem& problem, CurveShape shape, std::size_t scan_steps);

  /// Returns the best curves of an invertible model (valid_curves.h) with the convergence rates k of the
  /// trial. If the RMS error is above `limit`, the result may have an infinite RMS error instead.
  Fitted fit(const Trial& trial, double limit = std::numeric_limits<double>::infinity());

  /// Returns how well each fold is predicted by a fit to the other folds. Fold 0 is a part of every fit and
  /// is not predicted. Each fold has its own offset and drift. If a fold is a whole dataset, its gain is the
  /// mean gain of the other datasets. The result is empty if a convergence rate k is so negative that the fit
  /// contains infinite numbers.
  std::vector<LeftOut> left_out(const Trial& trial);
  /// Returns the RMS error over all folds of left_out(). Returns infinity if left_out() is empty, and
  /// `nullopt` if nothing is held out.
  std::optional<double> held_out(const Trial& trial);

 private:
  std::vector<NormalEquations> systems(const Trial& trial);
  Fitted fitted(const Eliminated& system, double samples, const ValidCurves::Solution& solution,
                const Trial& trial) const;
  void prepare(const Trial& trial);
  LeftOut judged(const NormalEquations& fold, const Eigen::VectorXd& shared) const;
  ValidCurves::Solution solve(const NormalEquations& system, const Trial& trial,
                              double limit = std::numeric_limits<double>::infinity());
  Nuisances nuisances(std::size_t excerpt) const {
    return problem_.nuisances.empty() ? Nuisances{} : problem_.nuisances[excerpt];
  }
  Eigen::Index curve_unknowns() const { return 2 * shape_.coefficients() - 1; }
  Eigen::Index shared_unknowns() const { return curve_unknowns() + problem_.regressors; }

  const Problem& problem_;
  CurveShape shape_;
  ValidCurves curves_;
  std::vector<Regression> regressions_;  // equations of each dataset for the last trial; valid for all k
  std::optional<Trial> prepared_;
};

}  // namespace hystcan::identification
