#include "identification/ascending_choice.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "model/reference_curve.h"
#include "model/validity.h"

namespace hystcan::identification {
namespace {

using model::Basis;
using model::HysteresisParameters;
using model::Interval;
using model::ReferenceCurve;

constexpr int longest_curve = 32;  // maximum order of a reference curve
constexpr std::size_t grid_steps = 400;

/// Returns the convergence function g at the input v. It is 1 at the lower threshold and falls to 0 at the
/// upper one.
double convergence(const HysteresisParameters& p, double v) {
  const Interval range = p.input_range();
  const double whole = p.place(range.hi) - p.place(range.lo), rest = p.place(range.hi) - p.place(v);
  const double k = p.k_ascending;
  if (k == 0.0) return rest / whole;
  if (k < 0.0) return std::expm1(k * rest) / std::expm1(k * whole);
  return std::exp(k * (rest - whole)) * std::expm1(-k * rest) / std::expm1(-k * whole);
}

double gap(const HysteresisParameters& p) {
  return p.lower_point().level - p.ascending.value(p.input_range().lo);
}

double branch_from_lower(const HysteresisParameters& p, double v) {
  return p.ascending.value(v) + gap(p) * convergence(p, v);
}

/// Returns the curve with the coefficients `c`, plus a straight line. The line is chosen so that the sum
/// equals branch_from_lower() exactly at the lower threshold and at the upper threshold. `one` and `line`:
/// the coefficients of the constant 1, and of the line that rises from -1 to 1 between the thresholds.
ReferenceCurve with_exact_ends(const HysteresisParameters& p, std::vector<double> c,
                               const std::vector<double>& one, const std::vector<double>& line) {
  const Interval range = p.input_range();
  const ReferenceCurve near = p.ascending.with(c);
  const double at_lo = p.lower_point().level - near.value(range.lo),
               at_hi = p.upper_point().level - near.value(range.hi);
  for (std::size_t i = 0; i < c.size(); ++i)
    c[i] += 0.5 * (at_hi + at_lo) * one[i] + 0.5 * (at_hi - at_lo) * line[i];
  return p.ascending.with(c);
}

/// Returns a polynomial near branch_from_lower(), the branch that rises from the descending curve at the
/// lower threshold. The polynomial interpolates this branch at the zeros of a Chebyshev polynomial. A
/// straight line is then added, so that the values at both thresholds are exact.
ReferenceCurve polynomial_near(const HysteresisParameters& p, int order) {
  const Interval range = p.input_range();
  const auto count = static_cast<std::size_t>(order) + 1;
  std::vector<double> c(count, 0.0), one(count, 0.0), line(count, 0.0);
  one[0] = line[1] = 1.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    const double value =
        branch_from_lower(p, 0.5 * (range.lo + range.hi) + 0.5 * range.span() * std::cos(angle));
    for (std::size_t j = 0; j < count; ++j)
      c[j] += (j == 0 ? 1.0 : 2.0) / static_cast<double>(count) * value *
              std::cos(static_cast<double>(j) * angle);
  }
  return with_exact_ends(p, std::move(c), one, line);
}

/// Returns a spline near branch_from_lower(), the branch that rises from the descending curve at the lower
/// threshold. The spline has the knots of the ascending curve and is fitted by least squares. A straight line
/// is then added, so that the values at both thresholds are exact.
ReferenceCurve spline_near(const HysteresisParameters& p) {
  const std::vector<double>& knots = p.ascending.knots();
  const std::vector<double> at = model::grid_of(p.input_range(), knots, grid_steps);
  const auto unknowns = static_cast<Eigen::Index>(p.ascending.coefficients().size());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(at.size()), unknowns);
  Eigen::VectorXd values(rows.rows());
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const double v = at[static_cast<std::size_t>(i)];
    const model::BSplines b = model::bsplines(knots, v);
    for (std::size_t j = 0; j < b.at.size(); ++j)
      rows(i, static_cast<Eigen::Index>(b.first + j)) = b.at[j].value;
    values[i] = branch_from_lower(p, v);
  }
  const Eigen::VectorXd solved = rows.householderQr().solve(values);
  const Interval range = p.input_range();
  std::vector<double> line = model::greville_points(knots);
  for (double& v : line) v = (2.0 * v - range.lo - range.hi) / range.span();
  return with_exact_ends(p, {solved.begin(), solved.end()}, std::vector<double>(line.size(), 1.0), line);
}

bool is_within(const HysteresisParameters& p, const ReferenceCurve& curve, double tolerance) {
  return std::ranges::all_of(model::grid_of(p.input_range(), p.ascending.knots(), grid_steps), [&](double v) {
    return std::abs(curve.value(v) - branch_from_lower(p, v)) <= tolerance;
  });
}

std::optional<ReferenceCurve> curve_near(const HysteresisParameters& p, double tolerance) {
  if (p.ascending.basis() == Basis::spline) {
    ReferenceCurve curve = spline_near(p);
    return is_within(p, curve, tolerance) ? std::optional(std::move(curve)) : std::nullopt;
  }
  const int least = std::max(1, static_cast<int>(p.ascending.coefficients().size()) - 1);
  for (int order = least; order <= longest_curve; ++order) {
    ReferenceCurve curve = polynomial_near(p, order);
    if (is_within(p, curve, tolerance)) return curve;
  }
  return std::nullopt;
}

}  // namespace

HysteresisParameters with_ascending_from_lower(const HysteresisParameters& parameters, double tolerance) {
  const auto curve = curve_near(parameters, tolerance);
  if (!curve) return parameters;
  HysteresisParameters chosen = parameters;
  chosen.ascending = *curve;
  try {
    model::check_curves(chosen);
    model::check_branches(chosen);
  } catch (const std::invalid_argument&) {
    return parameters;
  }
  return chosen;
}

bool begins_at_lower_point(const HysteresisParameters& parameters) {
  constexpr double rounding = 1e-9;  // tolerance, as a share of the output range
  const Interval levels = parameters.output_range();
  constexpr double last_digits = 8.0 * std::numeric_limits<double>::epsilon();
  return std::abs(gap(parameters)) <= rounding * levels.span() + last_digits * std::abs(levels.hi);
}

}  // namespace hystcan::identification
