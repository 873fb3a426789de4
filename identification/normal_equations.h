// The normal equations of
//   sum (row theta - y)^2 = theta' H theta - 2 g' theta + square
#pragma once

#include <Eigen/Core>

namespace hystcan::identification {

struct NormalEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double square = 0.0;
  double samples = 0.0;

  explicit NormalEquations(Eigen::Index unknowns)
      : H(Eigen::MatrixXd::Zero(unknowns, unknowns)), g(Eigen::VectorXd::Zero(unknowns)) {}
  NormalEquations& operator+=(const NormalEquations& other);
  /// Subtracts a share of `other`, which must be a part of the sum in these equations.
  void take_away(const NormalEquations& other, double share);
  /// Adds equations whose first `shared` unknowns are the first ones here; their other unknowns start at
  /// `own`.
  void add(const NormalEquations& other, Eigen::Index shared, Eigen::Index own);
  /// False if a k is so negative that branches overflow.
  bool is_finite() const { return H.allFinite() && g.allFinite(); }
  /// Changes the equations to outputs divided by `gain`.
  void divide_outputs(double gain);
  double residual_square(const Eigen::VectorXd& theta) const;
  /// Removes from the residuals the part that `direction` can explain. Then, for every theta, the residual is
  /// the minimum over a in theta + a direction.
  void leave_out(const Eigen::VectorXd& direction);
};

/// Equations from which the last unknowns are eliminated: for any values of the first unknowns, the last
/// unknowns have their best values.
class Eliminated {
 public:
  /// `remaining`: number of first unknowns, which remain.
  Eliminated(const NormalEquations& system, Eigen::Index remaining);

  const NormalEquations& rest() const { return rest_; }
  /// Returns `theta`, followed by the best values of the eliminated unknowns.
  Eigen::VectorXd completed(const Eigen::VectorXd& theta) const;

 private:
  NormalEquations rest_;
  Eigen::VectorXd eliminated_at_zero_;  // the eliminated unknowns at theta = 0
  Eigen::MatrixXd by_theta_;            // their change with theta
};

}  // namespace hystcan::identification
