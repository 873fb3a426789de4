// The linear least-squares problem for the coefficients theta of the reference curves, for a given
// convergence rate k (branch_rows.h). The problem is summed up as normal equations, branch by branch.
//
// The sums of products B_i B_j of the basis functions do not depend on k and are computed once. Another k
// therefore costs only one exponential and n + 4 products per sample, with n + 1 basis functions.
//
// After theta there are more linear unknowns. First come the regressors, which all datasets share, and then
// the unknowns of a single dataset: its offset (column 1) and its linear drift (column: time from -1/2 to
// 1/2).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "identification/branch_rows.h"
#include "identification/curve_basis.h"
#include "identification/dataset.h"
#include "identification/normal_equations.h"
#include "identification/path.h"

namespace hystcan::identification {

/// Selects the unknowns that belong to a single dataset. If `offset` is true, the fit finds an offset of the
/// dataset's output. If `drift` is true, the fit finds a linear drift of this output.
struct Nuisances {
  bool offset = false;
  bool drift = false;

  Eigen::Index count() const { return (offset ? 1 : 0) + (drift ? 1 : 0); }
};

class Regression {
 public:
  /// Mark in Dataset::fold for a sample that is not fitted. The path includes the input of this sample.
  static constexpr int left_out = -1;
  /// `samples`: every sample has a fold, from 0 to folds - 1, or left_out. time_s is needed only for a drift;
  /// otherwise it may be empty. The weights of the samples do not apply to regressors, offset and drift.
  Regression(Path path, CurveBasis basis, const Dataset& samples, int folds, Nuisances nuisances = {});

  /// Returns the number of unknowns: theta, then the regressors, then the nuisances.
  Eigen::Index unknowns() const { return basis_.unknowns() + regressors_ + nuisances_.count(); }
  /// Adds the normal equations of each fold to `folds`, for the convergence rates in `pace`.
  void add(const Pace& pace, std::vector<NormalEquations>& folds) const;

 private:
  struct Sums {  // weighted sums over the samples of one run in one fold
    std::size_t branch = 0;
    int fold = 0;
    Eigen::Index begin = 0, count = 0;  // first sample and number of samples, as indices of distance_
    Eigen::VectorXd columns;            // sum over the samples: column of columns_ times weight
    double square = 0.0;                // sum of the squared weights
  };

  void gather(const Dataset& samples);
  void sum_up();
  void add_run(const Sums& run, const Pace& pace, const BranchRows& rows, NormalEquations& to,
               Eigen::Ref<Eigen::MatrixXd> left, Eigen::Ref<Eigen::MatrixXd> right) const;

  Path path_;
  CurveBasis basis_;
  Eigen::Index regressors_;
  Nuisances nuisances_;
  // For each fold, the part of the normal equations that does not depend on the convergence rates.
  std::vector<NormalEquations> base_;
  std::vector<Sums> runs_;    // sums of each run of samples, sorted by fold
  Eigen::VectorXd distance_;  // for each sample that counts, its distance from the start of its branch
  Eigen::VectorXd weight_;
  // One column for each fitted sample: basis functions, regressors, terms of the dataset's own offset and
  // drift, output. Only the basis functions and the output are multiplied by the weight of the sample.
  Eigen::MatrixXd columns_;
};

}  // namespace hystcan::identification
