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

}  // namespace hystcan::identification
