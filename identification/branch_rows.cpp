#include "identification/branch_rows.h"

#include <cmath>

namespace hystcan::identification {
namespace {

double phi(double k, double d) { return std::abs(k * d) > 1e-17 ? -std::expm1(-k * d) / k : d; }

}  // namespace

// On a branch, the output is f_0(v) + c - S phi(d): reference curve f_0 at the input v, constants c and S of
// the branch, distance d from its start. Computes c and S of each branch when the branch starts. Both are
// linear in theta, the coefficients of the reference curves. Therefore each is stored as a row; the product
// of the row with theta is c or S.
BranchRows::BranchRows(const Path& path, const CurveBasis& basis, const Pace& pace)
    : basis_(basis), pace_(pace) {
  const auto count = static_cast<Eigen::Index>(path.branches.size());
  offset_ = convergence_ = Eigen::MatrixXd::Zero(basis.unknowns(), count);
  Eigen::VectorXd here(basis.size());
  for (Eigen::Index j = 0; j < count; ++j) {
    const PathBranch& branch = path.branches[static_cast<std::size_t>(j)];
    if (branch.virgin) continue;
    const double k = pace.k(branch.direction);
    const auto distance = [&](double from) {
      return std::abs(basis.place(branch.start) - basis.place(from));
    };
    const double length = distance(branch.target);
    basis.values(branch.start, here);
    Eigen::VectorXd start = basis.row(opposite(branch.direction), here);
    if (branch.parent != PathBranch::none) {
      const double d = distance(path.branches[branch.parent].start);
      start +=
          offset(branch.parent) - convergence(branch.parent) * phi(pace.k(opposite(branch.direction)), d);
    }
    offset_.col(j) = start - basis.row(branch.direction, here);
    Eigen::VectorXd gap = offset_.col(j);
    if (branch.below != PathBranch::none) {
      const double d = distance(path.branches[branch.below].start);
      gap -= offset(branch.below) - convergence(branch.below) * phi(k, d);
      convergence_.col(j) = convergence(branch.below) * std::exp(-k * d);
    }
    if (length > 0.0) convergence_.col(j) += gap / phi(k, length);
  }
}

Eigen::VectorXd BranchRows::slope(const PathBranch& shape, std::size_t branch, double input) const {
  Eigen::VectorXd here(basis_.size());
  basis_.slopes(input, here);
  const double d = std::abs(basis_.place(input) - basis_.place(shape.start));
  const double decay = std::exp(-pace_.k(shape.direction) * d);
  return basis_.row(shape.direction, here) / basis_.stretch(input) -
         sign(shape.direction) * decay * convergence(branch);
}

}  // namespace hystcan::identification
