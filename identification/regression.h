// What the outputs of a dataset say of the reference curves, k being given: a linear least-squares problem,
// its rows as in branch_rows.h.
//
// Its normal equations are summed branch by branch: the sums of T_i T_j do not depend on k and are made
// once, so that another k costs one exponential and n + 4 products per sample.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "identification/branch_rows.h"
#include "identification/path.h"

namespace hystcan::identification {

/// sum (row theta - y)^2 = theta' H theta - 2 g' theta + square.
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
  /// `fold[i]`: which part sample i belongs to, 0 to folds - 1; a sample of fold `left_out` counts nowhere.
  static constexpr int left_out = -1;
  Regression(Path path, model::Interval thresholds, int order, std::span<const double> input,
             std::span<const double> output, std::span<const int> fold, int folds);

  Eigen::Index unknowns() const { return 2 * order_ + 1; }
  /// Adds to one system per fold.
  void add(const Pace& pace, std::vector<NormalEquations>& folds) const;

 private:
  struct Sums {  // of one run within one fold
    std::size_t branch = 0;
    int fold = 0;
    Eigen::Index begin = 0, count = 0;  // in distance_ and on
    Eigen::VectorXd basis;              // sum of T
    double output = 0.0;
  };

  void gather(std::span<const double> input, std::span<const double> output, std::span<const int> fold);
  void sum_up(Sums& run);
  void add_run(const Sums& run, const Pace& pace, const BranchRows& rows, NormalEquations& to) const;

  Path path_;
  model::Interval thresholds_;
  Eigen::Index order_;
  std::vector<NormalEquations> base_;  // per fold: what does not depend on k
  std::vector<Sums> runs_;
  Eigen::VectorXd distance_;  // |v - v_s| of each sample that counts
  Eigen::VectorXd output_;
  Eigen::MatrixXd basis_;  // T of each sample that counts, a column each
};

}  // namespace hystcan::identification
