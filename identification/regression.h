// The linear least-squares problem of the reference curves for a given k, with the rows of branch_rows.h.
//
// Its normal equations are summed branch by branch. The sums of T_i T_j do not depend on k and are computed
// once, so that another k costs one exponential and n + 4 products per sample.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "identification/branch_rows.h"
#include "identification/path.h"

namespace hystcan::identification {

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
  NormalEquations& operator-=(const NormalEquations& other);
  double residual_square(const Eigen::VectorXd& theta) const;
};

class Regression {
 public:
  /// `fold[i]`: the fold of sample i, 0 to folds - 1. A sample with `left_out` does not count in any fold.
  static constexpr int left_out = -1;
  Regression(Path path, model::Interval thresholds, int order, std::span<const double> input,
             std::span<const double> output, std::span<const int> fold, int folds);

  Eigen::Index unknowns() const { return 2 * order_ + 1; }
  /// Adds the equations of each fold to `folds`.
  void add(const Pace& pace, std::vector<NormalEquations>& folds) const;

 private:
  struct Sums {  // sums over one run within one fold
    std::size_t branch = 0;
    int fold = 0;
    Eigen::Index begin = 0, count = 0;  // samples, as indices of distance_
    Eigen::VectorXd basis;              // sum of T
    double output = 0.0;
  };

  void gather(std::span<const double> input, std::span<const double> output, std::span<const int> fold);
  void sum_up(Sums& run);
  void add_run(const Sums& run, const Pace& pace, const BranchRows& rows, NormalEquations& to) const;

  Path path_;
  model::Interval thresholds_;
  Eigen::Index order_;
  std::vector<NormalEquations> base_;  // per fold: the part that does not depend on k
  std::vector<Sums> runs_;
  Eigen::VectorXd distance_;  // |v - v_s| of each sample that counts
  Eigen::VectorXd output_;
  Eigen::MatrixXd basis_;  // T of each sample that counts, one column per sample
};

}  // namespace hystcan::identification
