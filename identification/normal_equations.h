// The normal equations of a linear least-squares problem with the unknowns theta. Each sample has a row and a
// right side y:
//
//   sum over samples of (row theta - y)^2 = theta' H theta - 2 g' theta + square
//
//   H        sum of row' row
//   g        sum of y row'
//   square   sum of y^2
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
  /// Subtracts the sums H, g and square of `other`, multiplied by `share`. The samples of `other` must be
  /// among the samples of this object. The call lowers their weight; a share of 1 removes them.
  void take_away(const NormalEquations& other, double share);
  /// Adds the sums of `other` to those of this object. The unknowns of `other` are also unknowns of this
  /// object, but at other indices: the first `shared` unknowns keep their indices, and the remaining ones
  /// begin at index `own` of this object.
  void add(const NormalEquations& other, Eigen::Index shared, Eigen::Index own);
  /// Returns false if H or g contains a number that is not finite. This happens if a convergence rate k is
  /// very negative: the terms e^{-k d} of the branches then overflow (d: distance along a branch).
  bool is_finite() const { return H.allFinite() && g.allFinite(); }
  /// Divides all right sides y by `gain`.
  void divide_outputs(double gain);
  double residual_square(const Eigen::VectorXd& theta) const;
  /// Makes the residual independent of the part of theta along `direction`. For every theta, the new residual
  /// is the smallest of the former residuals at theta + s * direction, over all numbers s.
  void leave_out(const Eigen::VectorXd& direction);
};

/// Normal equations from which the last unknowns are eliminated. They describe the residual as a function of
/// the first unknowns, with the best values of the last unknowns.
class Eliminated {
 public:
  /// `remaining`: number of unknowns that are not eliminated; they are the first ones of `system`.
  Eliminated(const NormalEquations& system, Eigen::Index remaining);

  const NormalEquations& rest() const { return rest_; }
  /// Returns all unknowns of the original system. `theta` contains values of the remaining unknowns, the
  /// first ones of the system. The eliminated unknowns follow, with the best values for this theta.
  Eigen::VectorXd completed(const Eigen::VectorXd& theta) const;

 private:
  NormalEquations rest_;
  Eigen::VectorXd eliminated_at_zero_;  // best values of the eliminated unknowns at theta = 0
  Eigen::MatrixXd by_theta_;            // the eliminated unknowns are eliminated_at_zero_ - by_theta_ * theta
};

}  // namespace hystcan::identification
