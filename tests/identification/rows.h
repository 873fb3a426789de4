// The rows of theta, computed sample by sample directly from the definition in identification/regression.h.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "identification/path.h"
#include "identification/regression.h"
#include "model/hysteresis_parameters.h"

namespace hystcan::identification {

inline CurveShape shape_of(const model::HysteresisParameters& parameters) {
  const auto &up = parameters.ascending, &down = parameters.descending;
  if (up.basis() == model::Basis::spline) return CurveShape::spline(up.knots());
  return CurveShape::polynomial(
      static_cast<int>(std::max(up.coefficients().size(), down.coefficients().size())) - 1);
}

/// a_i, then q_i: a_i - d_i for i > 0 (polynomials; missing coefficients of the shorter curve are zero), d_i
/// - a_i for i < n (splines).
inline Eigen::VectorXd theta_of(const model::HysteresisParameters& parameters) {
  const auto& a = parameters.ascending.coefficients();
  const auto& d = parameters.descending.coefficients();
  const CurveShape shape = shape_of(parameters);
  const Eigen::Index n = shape.coefficients() - 1;
  const auto coefficient = [](const std::vector<double>& of, Eigen::Index i) {
    return i < std::ssize(of) ? of[static_cast<std::size_t>(i)] : 0.0;
  };
  Eigen::VectorXd theta(2 * n + 1);
  for (Eigen::Index i = 0; i <= n; ++i) theta[i] = coefficient(a, i);
  for (Eigen::Index i = 0; i < n; ++i)
    theta[n + 1 + i] = shape.is_spline() ? coefficient(d, i) - coefficient(a, i)
                                         : coefficient(a, i + 1) - coefficient(d, i + 1);
  return theta;
}

inline std::size_t branch_of(const Path& path, std::size_t sample) {
  const auto run = std::ranges::upper_bound(path.runs, sample, {}, &identification::Run::begin) - 1;
  return run->branch;
}

struct Rows {
  Path path;
  Pace pace;
  CurveBasis basis;
  BranchRows rows;

  Rows(Path travelled, CurveBasis of_basis, Pace at_pace)
      : path(std::move(travelled)), pace(at_pace), basis(std::move(of_basis)), rows(path, basis, pace) {}
  Rows(Path travelled, const model::HysteresisParameters& parameters)
      : Rows(std::move(travelled), {shape_of(parameters), parameters.input_range()},
             {parameters.k_ascending, parameters.k_descending}) {}

  /// The row of one sample:
  ///   x = f_0(v) + c - S phi(|v - v_s|)
  Eigen::VectorXd at(std::size_t sample, double input) const {
    const std::size_t branch = branch_of(path, sample);
    const PathBranch& shape = path.branches[branch];
    const double k = pace.k(shape.direction), d = std::abs(input - shape.start);
    Eigen::VectorXd here(basis.size());
    basis.values(input, here);
    const double phi = k == 0.0 ? d : -std::expm1(-k * d) / k;
    return basis.row(shape.direction, here) + rows.offset(branch) - phi * rows.convergence(branch);
  }
};

}  // namespace hystcan::identification
