// Finds the shortest vector that satisfies linear inequalities, which are given one after the other:
//
//   min |z|,     g_i . z >= h_i
//
// Dual active-set method: each inequality that z violates moves z to the shortest vector that satisfies it
// and the active inequalities; some of these may become inactive. |z| never falls, so the method terminates.
// With n unknowns an inequality costs O(n^2).
//
// D. Goldfarb, A. Idnani, "A numerically stable dual method for solving strictly convex quadratic programs",
// Mathematical Programming 27, 1983; here with the unit matrix as the quadratic form.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace hystcan::identification {

class LeastDistance {
 public:
  explicit LeastDistance(Eigen::Index unknowns);

  const Eigen::VectorXd& z() const { return z_; }

  /// Adds the inequality g . z >= h. `g` must not be zero. Returns false, and leaves z undefined, if no z
  /// satisfies it together with the active ones. An inequality that has become inactive may be violated again
  /// and must then be added again.
  bool meet(const Eigen::VectorXd& g, double h);

 private:
  Eigen::Index in_force() const { return static_cast<Eigen::Index>(multipliers_.size()); }
  Eigen::VectorXd in_triangle(const Eigen::VectorXd& of) const;
  void enter(const Eigen::VectorXd& components);
  void drop(std::size_t place);

  Eigen::VectorXd z_;
  Eigen::MatrixXd q_;  // orthogonal; its first columns span the g of the active inequalities
  Eigen::MatrixXd r_;  // triangle: these g in the basis of these columns
  std::vector<double> multipliers_;
};

}  // namespace hystcan::identification
