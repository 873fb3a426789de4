// Finds the shortest vector z that satisfies linear inequalities. The inequalities are given one after the
// other:
//
//   min |z|,     g_i . z >= h_i
//
// The method is a dual active-set method. If z violates a new inequality, z moves to the shortest vector that
// satisfies the new inequality and the active ones. In this move, some active inequalities may become
// inactive. |z| never decreases, so that the method ends. With n unknowns, an inequality costs O(n^2).
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

  /// Adds the inequality g . z >= h and updates z. `g` must not be zero. Returns false if no z satisfies this
  /// inequality together with the active ones; z is then undefined. A later call may make an inequality
  /// inactive and violate it. In that case the caller must add the inequality again.
  bool meet(const Eigen::VectorXd& g, double h);

 private:
  Eigen::Index in_force() const { return static_cast<Eigen::Index>(multipliers_.size()); }
  Eigen::VectorXd in_triangle(const Eigen::VectorXd& of) const;
  void enter(const Eigen::VectorXd& components);
  void drop(std::size_t place);

  Eigen::VectorXd z_;
  // Orthogonal matrix. Its first columns span the vectors g of the active inequalities g . z >= h.
  Eigen::MatrixXd q_;
  // Upper triangle: column i contains the vector g of active inequality i (g . z >= h), as components along
  // the first columns of q_.
  Eigen::MatrixXd r_;
  std::vector<double> multipliers_;
};

}  // namespace hystcan::identification
