// The rows of theta, computed sample by sample directly from the definition in identification/branch_rows.h.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "identification/branch_rows.h"
#include "identification/path.h"
#include "model/hysteresis_parameters.h"

namespace hystcan::identification {

/// a_i, then q_i = a_i - d_i. Missing coefficients of the shorter curve are zero.
inline Eigen::VectorXd theta_of(const model::HysteresisParameters& parameters) {
  const auto& a = parameters.ascending.chebyshev_coefficients();
  const auto& d = parameters.descending.chebyshev_coefficients();
  const auto order = static_cast<Eigen::Index>(std::max(a.size(), d.size())) - 1;
  const auto coefficient = [](const std::vector<double>& of, Eigen::Index i) {
    return i < std::ssize(of) ? of[static_cast<std::size_t>(i)] : 0.0;
  };
  Eigen::VectorXd theta(2 * order + 1);
  for (Eigen::Index i = 0; i <= order; ++i) {
    theta[i] = coefficient(a, i);
    if (i > 0) theta[order + i] = coefficient(a, i) - coefficient(d, i);
  }
  return theta;
}

inline std::size_t branch_of(const Path& path, std::size_t sample) {
  const auto run = std::ranges::upper_bound(path.runs, sample, {}, &identification::Run::begin) - 1;
  return run->branch;
}

struct Rows {
  Path path;
  model::Interval thresholds;
  Pace pace;
  Eigen::Index order;
  BranchRows rows;

  Rows(Path travelled, model::Interval between, Eigen::Index of_order, Pace at_pace)
      : path(std::move(travelled)),
        thresholds(between),
        pace(at_pace),
        order(of_order),
        rows(path, thresholds, order, pace) {}
  Rows(Path travelled, const model::HysteresisParameters& parameters)
      : Rows(std::move(travelled), parameters.input_range(), (theta_of(parameters).size() - 1) / 2,
             {parameters.k_ascending, parameters.k_descending}) {}

  /// The row of one sample:
  ///   x = f_0(v) + c - S phi(|v - v_s|)
  Eigen::VectorXd at(std::size_t sample, double input) const {
    const std::size_t branch = branch_of(path, sample);
    const PathBranch& shape = path.branches[branch];
    const double k = pace.k(shape.direction), d = std::abs(input - shape.start);
    Eigen::VectorXd basis(order + 1);
    chebyshev_row(thresholds, input, basis);
    const double phi = k == 0.0 ? d : -std::expm1(-k * d) / k;
    return curve_row(shape.direction, basis, 1.0) + rows.offset(branch) - phi * rows.convergence(branch);
  }
};

}  // namespace hystcan::identification
