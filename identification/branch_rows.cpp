#include "identification/branch_rows.h"

#include <cmath>

namespace hystcan::identification {
namespace {

double phi(double k, double d) { return std::abs(k * d) > 1e-17 ? -std::expm1(-k * d) / k : d; }

}  // namespace

void chebyshev_row(model::Interval thresholds, double input, Eigen::Ref<Eigen::VectorXd> row) {
  const double s = (2.0 * input - thresholds.lo - thresholds.hi) / thresholds.span();
  row[0] = 1.0;
  if (row.size() > 1) row[1] = s;
  for (Eigen::Index i = 2; i < row.size(); ++i) row[i] = 2.0 * s * row[i - 1] - row[i - 2];
}

// T_i'(s) = i U_{i-1}(s)
void chebyshev_slope_row(model::Interval thresholds, double input, Eigen::Ref<Eigen::VectorXd> row) {
  const double s = (2.0 * input - thresholds.lo - thresholds.hi) / thresholds.span();
  const double ds_dv = 2.0 / thresholds.span();
  double before = 0.0, u = 1.0;
  row[0] = 0.0;
  for (Eigen::Index i = 1; i < row.size(); ++i) {
    row[i] = static_cast<double>(i) * u * ds_dv;
    const double next = 2.0 * s * u - before;
    before = u;
    u = next;
  }
}

// Rising:  (T, 0, ..., 0)
// Falling: (T, 1 - T_1, ..., 1 - T_n)
Eigen::VectorXd curve_row(model::Direction direction, const Eigen::VectorXd& basis, double one) {
  const Eigen::Index order = basis.size() - 1;
  Eigen::VectorXd row = Eigen::VectorXd::Zero(2 * order + 1);
  row.head(order + 1) = basis;
  if (direction == model::Direction::descending) row.tail(order) = one - basis.tail(order).array();
  return row;
}

model::HysteresisParameters parameters_of(const Eigen::VectorXd& theta, model::Interval thresholds,
                                          const Pace& pace) {
  const Eigen::Index order = (theta.size() - 1) / 2;
  std::vector<double> ascending(theta.data(), theta.data() + order + 1), descending = ascending;
  for (Eigen::Index i = 1; i <= order; ++i) {
    descending[0] += theta[order + i];
    descending[static_cast<std::size_t>(i)] -= theta[order + i];
  }
  model::HysteresisParameters parameters;
  parameters.ascending = model::ReferenceCurve(model::Basis::chebyshev, ascending, thresholds);
  parameters.descending = model::ReferenceCurve(model::Basis::chebyshev, descending, thresholds);
  parameters.k_ascending = pace.k_ascending;
  parameters.k_descending = pace.k_descending;
  return parameters;
}

// Computes c and S as at a reversal (model/hysteresis.h), for each unknown.
BranchRows::BranchRows(const Path& path, model::Interval thresholds, Eigen::Index order, const Pace& pace)
    : thresholds_(thresholds), order_(order), pace_(pace) {
  const auto count = static_cast<Eigen::Index>(path.branches.size());
  offset_ = convergence_ = Eigen::MatrixXd::Zero(2 * order + 1, count);
  Eigen::VectorXd basis(order + 1);
  for (Eigen::Index j = 0; j < count; ++j) {
    const PathBranch& branch = path.branches[static_cast<std::size_t>(j)];
    if (branch.virgin) continue;
    const double k = pace.k(branch.direction);
    const double length = std::abs(branch.target - branch.start);
    chebyshev_row(thresholds, branch.start, basis);
    Eigen::VectorXd start = curve_row(opposite(branch.direction), basis, 1.0);
    if (branch.parent != PathBranch::none) {
      const double d = std::abs(branch.start - path.branches[branch.parent].start);
      start +=
          offset(branch.parent) - convergence(branch.parent) * phi(pace.k(opposite(branch.direction)), d);
    }
    offset_.col(j) = start - curve_row(branch.direction, basis, 1.0);
    Eigen::VectorXd gap = offset_.col(j);
    if (branch.below != PathBranch::none) {
      const double d = std::abs(branch.start - path.branches[branch.below].start);
      gap -= offset(branch.below) - convergence(branch.below) * phi(k, d);
      convergence_.col(j) = convergence(branch.below) * std::exp(-k * d);
    }
    if (length > 0.0) convergence_.col(j) += gap / phi(k, length);
  }
}

Eigen::VectorXd BranchRows::slope(const PathBranch& shape, std::size_t branch, double input) const {
  Eigen::VectorXd basis(order_ + 1);
  chebyshev_slope_row(thresholds_, input, basis);
  const double decay = std::exp(-pace_.k(shape.direction) * std::abs(input - shape.start));
  return curve_row(shape.direction, basis, 0.0) - sign(shape.direction) * decay * convergence(branch);
}

}  // namespace hystcan::identification
