// The linear least-squares problem of the reference curves for a given k, with the rows of BranchRows.
//
// Its normal equations are summed branch by branch. The sums of B_i B_j do not depend on k and are computed
// once, so that another k costs one exponential and n + 4 products per sample.
//
// After theta there are further linear unknowns: first the regressors, which all datasets share, then the
// unknowns of a single dataset: a zero and a slow drift (columns 1 and its time from -1/2 to 1/2).
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

/// Unknowns of a single dataset in addition to the curves.
struct Nuisances {
  bool offset = false;
  bool drift = false;

  Eigen::Index count() const { return (offset ? 1 : 0) + (drift ? 1 : 0); }
};

class Regression {
 public:
  /// Instead of a fold: the sample does not count, but the path includes its input.
  static constexpr int left_out = -1;
  /// `samples`: time_s is needed only for a drift, else it may be empty; regressors and nuisances are not
  /// weighted. Every sample has a fold, from 0 to folds - 1, or left_out.
  Regression(Path path, CurveBasis basis, const Dataset& samples, int folds, Nuisances nuisances = {});

  /// Number of unknowns in theta, regressors and nuisances, in this order.
  Eigen::Index unknowns() const { return basis_.unknowns() + regressors_ + nuisances_.count(); }
  /// Adds the equations of each fold to `folds`.
  void add(const Pace& pace, std::vector<NormalEquations>& folds) const;

 private:
  struct Sums {  // sums over one run within one fold, weighted
    std::size_t branch = 0;
    int fold = 0;
    Eigen::Index begin = 0, count = 0;  // samples, as indices of distance_
    Eigen::VectorXd columns;            // sum of columns_
    double square = 0.0;                // sum of the weights
  };

  void gather(const Dataset& samples);
  void sum_up();
  void add_run(const Sums& run, const Pace& pace, const BranchRows& rows, NormalEquations& to,
               Eigen::Ref<Eigen::MatrixXd> left, Eigen::Ref<Eigen::MatrixXd> right) const;

  Path path_;
  CurveBasis basis_;
  Eigen::Index regressors_;
  Nuisances nuisances_;
  std::vector<NormalEquations> base_;  // per fold: the part that does not depend on k
  std::vector<Sums> runs_;             // fold by fold
  Eigen::VectorXd distance_;           // d of each sample that counts
  Eigen::VectorXd weight_;
  // One column for each sample: B, then regressors and nuisances, then the output. Regressors and nuisances
  // are not weighted.
  Eigen::MatrixXd columns_;
};

}  // namespace hystcan::identification
