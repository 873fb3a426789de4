// The linear least-squares problem of the reference curves for a given k, with the rows of BranchRows.
//
// Its normal equations are summed branch by branch. The sums of B_i B_j do not depend on k and are computed
// once, so that another k costs one exponential and n + 4 products per sample.
//
// After theta come further linear unknowns: those of regressors, which all datasets share, then what a
// dataset has of its own, a zero and a slow drift (columns 1 and its time from -1/2 to 1/2).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "identification/curve_basis.h"
#include "identification/dataset.h"
#include "identification/path.h"

namespace hystcan::identification {

/// Outputs and slopes along a path for a given k, as rows of the linear problem in theta, the coefficients of
/// the reference curves (curve_basis.h). On each branch of a path
///
///   x = f_0(v) + c - S phi(d),    d = |h(v) - h(v_s)|
///
/// c and S are linear in theta (model/hysteresis.h). Each branch has one row for c and one for S, which are
/// computed at its reversal.
class BranchRows {
 public:
  /// `basis` must outlive the rows.
  BranchRows(const Path& path, const CurveBasis& basis, const Pace& pace);

  auto offset(std::size_t branch) const { return offset_.col(static_cast<Eigen::Index>(branch)); }  // c
  auto convergence(std::size_t branch) const {
    return convergence_.col(static_cast<Eigen::Index>(branch));
  }  // S
  /// dx/dh at `input` on a branch of the path.
  Eigen::VectorXd slope(const PathBranch& shape, std::size_t branch, double input) const;

 private:
  const CurveBasis& basis_;
  Pace pace_;
  Eigen::MatrixXd offset_, convergence_;  // a column for each branch
};

/// What a dataset has of its own beside the curves.
struct Nuisances {
  bool offset = false;
  bool drift = false;

  Eigen::Index count() const { return (offset ? 1 : 0) + (drift ? 1 : 0); }
};

/// The normal equations of
///   sum (row theta - y)^2 = theta' H theta - 2 g' theta + square
struct NormalEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double square = 0.0;
  double samples = 0.0;

  explicit NormalEquations(Eigen::Index unknowns)
      : H(Eigen::MatrixXd::Zero(unknowns, unknowns)), g(Eigen::VectorXd::Zero(unknowns)) {}
  NormalEquations& operator+=(const NormalEquations& other);
  /// Takes away a share of equations that are part of these.
  void take_away(const NormalEquations& other, double share);
  /// Adds equations whose first `shared` unknowns are the first ones here; the others stand from `own` on.
  void add(const NormalEquations& other, Eigen::Index shared, Eigen::Index own);
  /// False if a k is so negative that branches grow beyond every number.
  bool is_finite() const { return H.allFinite() && g.allFinite(); }
  /// The equations for outputs divided by `gain`.
  void divide_outputs(double gain);
  double residual_square(const Eigen::VectorXd& theta) const;
  /// The residuals without the part that `direction` can explain: theta + a direction has the least square
  /// for every theta.
  void leave_out(const Eigen::VectorXd& direction);
};

/// Equations of which the last unknowns are eliminated: for every value of the others they are at their best.
class Eliminated {
 public:
  /// `kept`: the first unknowns.
  Eliminated(const NormalEquations& system, Eigen::Index kept);

  const NormalEquations& rest() const { return rest_; }
  /// `theta`, then the best values of the eliminated unknowns.
  Eigen::VectorXd completed(const Eigen::VectorXd& theta) const;

 private:
  NormalEquations rest_;
  Eigen::VectorXd alone_;     // the eliminated unknowns at theta = 0
  Eigen::MatrixXd by_theta_;  // how they follow theta
};

class Regression {
 public:
  /// In place of a fold: the sample does not count, but the path goes through its input.
  static constexpr int left_out = -1;
  /// `samples`: time_s is used for a drift only, else it may be empty; the regressors and the nuisances are
  /// not weighted. All samples have a fold, from 0 to folds - 1, or left_out.
  Regression(Path path, CurveBasis basis, const Dataset& samples, int folds, Nuisances nuisances = {});

  /// theta, the regressors, then the nuisances.
  Eigen::Index unknowns() const { return basis_.unknowns() + regressors_ + nuisances_.count(); }
  /// Adds the equations of each fold to `folds`.
  void add(const Pace& pace, std::vector<NormalEquations>& folds) const;

 private:
  struct Sums {  // sums over one run within one fold, weighted
    std::size_t branch = 0;
    int fold = 0;
    Eigen::Index begin = 0, count = 0;  // samples, as indices of distance_
    Eigen::VectorXd columns;            // sum of columns_
    double square = 0.0;                // of the weights
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
  // A column for each sample: B, then regressors and nuisances, then the output; those in the middle are not
  // weighted.
  Eigen::MatrixXd columns_;
};

}  // namespace hystcan::identification
