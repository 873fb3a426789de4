// Separable least squares (variable projection): the search varies only the few numbers of a Trial in which
// the output is not linear. For each Trial the best reference curves are one linear problem (regression.h).
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
  double k_span_ascending = 1.0;  ///< k times the span of the thresholds
  double k_span_descending = 1.0;
  double below = 0.0;  ///< lowest input minus lower threshold, in observed input spans
  double above = 0.0;  ///< upper threshold minus highest input, in observed input spans
  double delay_s = 0.0;
  double creep_per_decade = 0.0;        ///< share of the output (model/output_creep.h)
  std::vector<InitialMemory> memories;  ///< for each dataset
  std::vector<double> gains;            ///< gain of each dataset's output relative to the model; empty: all 1

  double gain(std::size_t dataset) const { return gains.empty() ? 1.0 : gains[dataset]; }
};

/// Largest creep that is searched. With the lags of the search, a creep of 1/6 per decade leaves half of the
/// output immediate, which is the limit in model/output_creep.h.
inline constexpr double most_creep_per_decade = 0.16;
/// Returns the creep with the lags of the search; `nullopt` if it is zero.
std::optional<model::OutputCreep::Config> creep_of(double per_decade);

inline constexpr int highest_order = 20;

/// The part of the problem that is the same for all trials.
struct Problem {
  std::vector<Excerpt> excerpts;
  std::vector<Nuisances> nuisances;  ///< unknowns of each excerpt; empty: none
  Eigen::Index regressors = 0;       ///< number of regressors in each excerpt
  int folds = 1;
  bool whole_excerpts = false;  ///< fold i + 1 has samples of excerpt i only (dataset.h)
  model::Interval observed;     ///< range of the inputs in the excerpts, folded
  model::Symmetry symmetry = model::Symmetry::none;
  double output_span = 1.0;
  // Limits for what the samples can determine.
  int highest_order = identification::highest_order;
  int most_pieces = 0;  ///< maximum pieces of a spline; 0: no splines
  /// Returns the knots of a spline with this number of pieces.
  std::function<std::vector<double>(int)> knots;
  double sample_time_s = 0.0;  ///< 0: no delay can be determined

  model::Interval thresholds(const Trial& trial) const;
};

struct Fitted {
  model::HysteresisParameters parameters;  ///< without units
  /// RMS error over the samples of the excerpts, output units; may be infinite.
  double rms = 0.0;
  bool valid = false;                   ///< curves and branches increase, so that an inverse exists
  double violation = 0.0;               ///< 0 if valid; else the distance from validity (valid_curves.h)
  std::vector<double> offsets, drifts;  ///< for each excerpt, output units; see Problem::nuisances
};

/// The samples of a fold, predicted by a fit without this fold.
struct LeftOut {
  double square = 0.0;  ///< sum of squared errors
  double samples = 0.0;
  double gain = 1.0;  ///< slope of the measured over the predicted outputs, each from its own zero

  double rms() const { return samples > 0.0 ? std::sqrt(square / samples) : 0.0; }
};

class SeparableFit {
 public:
  /// Resolution at which branches are checked. The final model is checked at the resolution of a model file.
  static constexpr std::size_t coarse_scan = 50, fine_scan = 200;
  SeparableFit(const Problem& problem, CurveShape shape, std::size_t scan_steps);

  /// Returns the best curves that make an invertible model (valid_curves.h) with the trial's k. An RMS error
  /// above `limit` may be returned as infinite.
  Fitted fit(const Trial& trial, double limit = std::numeric_limits<double>::infinity());

  /// Predicts each fold except fold 0, with its own zero and drift; the gain of a whole excerpt is the mean
  /// of the other gains. Empty if a k is so negative that nothing is finite.
  std::vector<LeftOut> left_out(const Trial& trial);
  /// Returns the RMS error over all of left_out(); infinite if that is empty; `nullopt` if the folds have no
  /// samples.
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
  std::vector<Regression> regressions_;  // equations for the last trial, for all k
  std::optional<Trial> prepared_;
};

}  // namespace hystcan::identification
