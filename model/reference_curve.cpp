#include "model/reference_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/text.h"
#include "model/extended.h"

namespace hystcan::model {
namespace {

constexpr std::size_t max_coefficients = 33;

void check_count(const std::vector<double>& coefficients) {
  if (coefficients.empty() || coefficients.size() > max_coefficients)
    refuse("reference curve has ", coefficients.size(), " coefficients, expected 1 to ", max_coefficients);
}

void check_numbers(const std::vector<double>& coefficients, const Interval& domain) {
  for (const double c : coefficients)
    if (!std::isfinite(c)) refuse("reference curve coefficient is ", c, ", expected a finite number");
  if (!std::isfinite(domain.lo) || !std::isfinite(domain.hi) || !(domain.lo < domain.hi) ||
      !std::isfinite(domain.span()))
    refuse("reference curve interval [", domain.lo, ", ", domain.hi, "], expected finite lo < hi");
}

std::vector<double> doubles(const std::vector<Extended>& numbers) {
  std::vector<double> result(numbers.size());
  std::ranges::transform(numbers, result.begin(),
                         [](Extended number) { return static_cast<double>(number); });
  return result;
}

// Converts a polynomial in v into a Chebyshev series in s, with v = centre + radius s. Uses Horner's rule;
// each partial sum is a Chebyshev series, which is multiplied by s with
//   s T_j = (T_{j+1} + T_{|j-1|}) / 2
std::vector<double> chebyshev_from_power(const std::vector<double>& power, const Interval& domain) {
  const Extended centre = (Extended(domain.lo) + domain.hi) / 2;
  const Extended radius = (Extended(domain.hi) - domain.lo) / 2;
  const std::size_t n = power.size();
  std::vector<Extended> sum(n), next(n);
  for (std::size_t i = n; i-- > 0;) {
    next.assign(n, {});
    for (std::size_t j = 0; j < n; ++j) {
      next[j] += centre * sum[j];
      if (j + 1 < n) next[j + 1] += radius * (j == 0 ? sum[j] : sum[j] / 2);
      if (j > 0) next[j - 1] += radius * sum[j] / 2;
    }
    next[0] += power[i];
    sum.swap(next);
  }
  return doubles(sum);
}

// Converts a Chebyshev series with the coefficients c_j into a polynomial in s. Uses Clenshaw's recurrence
//   b_j = c_j + 2 s b_{j+1} - b_{j+2}
// in which each b_j is a polynomial (for j = 0 without the factor 2).
std::vector<Extended> power_from_chebyshev(const std::vector<double>& c) {
  const std::size_t n = c.size();
  std::vector<Extended> b1(n + 1), b2(n + 1), b0(n + 1);
  for (std::size_t j = n; j-- > 0;) {
    const Extended twice = j == 0 ? 1.0L : 2.0L;
    for (std::size_t i = n; i > 0; --i) b0[i] = twice * b1[i - 1] - b2[i];
    b0[0] = c[j] - b2[0];
    b2.swap(b1);
    b1.swap(b0);
  }
  b1.resize(n);
  return b1;
}

template <class Numbers>
Extended sum_of_magnitudes(const Numbers& numbers) {
  Extended sum;
  for (const Extended number : numbers) sum += number.magnitude();
  return sum;
}

std::vector<double> checked(Basis basis, const std::vector<double>& coefficients, const Interval& domain) {
  check_count(coefficients);
  check_numbers(coefficients, domain);
  std::vector<double> result =
      basis == Basis::power ? chebyshev_from_power(coefficients, domain) : coefficients;
  if (!std::ranges::all_of(result, [](double c) { return std::isfinite(c); }))
    refuse("reference curve overflows on its interval, expected smaller coefficients");
  return result;
}

}  // namespace

ChebyshevSeries::ChebyshevSeries(std::vector<double> coefficients) : chebyshev_(std::move(coefficients)) {
  const std::vector<Extended> powers = power_from_chebyshev(chebyshev_);
  if (sum_of_magnitudes(powers) > 16 * sum_of_magnitudes(chebyshev_)) return;
  powers_ = doubles(powers);
  powers_.resize((powers.size() + 3) / 4 * 4);
}

// Returns the derivative of the curve by its input v. The curve is a Chebyshev series in s with the
// coefficients c_j; s is linear in v. The derivative is a Chebyshev series with the coefficients c'_j:
//   c'_{j-1} = c'_{j+1} + 2 j c_j
// This recurrence gives twice c'_0, and the derivative by s; therefore c'_0 is halved, and all c'_j are
// multiplied by ds/dv.
ChebyshevSeries ChebyshevSeries::derivative(double ds_dv) const {
  const std::size_t n = chebyshev_.size();
  std::vector<double> d(n + 1, 0.0);
  for (std::size_t j = n - 1; j > 0; --j) d[j - 1] = d[j + 1] + 2.0 * static_cast<double>(j) * chebyshev_[j];
  d[0] /= 2.0;
  d.resize(n > 1 ? n - 1 : 1);
  for (double& c : d) c *= ds_dv;
  return ChebyshevSeries(d);
}

double ChebyshevSeries::clenshaw(double s) const {
  double b1 = 0.0, b2 = 0.0;
  for (std::size_t j = chebyshev_.size() - 1; j > 0; --j) {
    const double b0 = chebyshev_[j] + (2.0 * s * b1 - b2);
    b2 = b1;
    b1 = b0;
  }
  return chebyshev_[0] + (s * b1 - b2);
}

ReferenceCurve::ReferenceCurve(Basis basis, const std::vector<double>& coefficients, Interval domain)
    : domain_(domain),
      centre_(domain.lo + domain.span() / 2.0),
      ds_dv_(2.0 / domain.span()),
      value_(checked(basis, coefficients, domain)),
      slope_(value_.derivative(ds_dv_)),
      curvature_(slope_.derivative(ds_dv_)) {
  if (value_.powers().empty() || slope_.powers().empty() || curvature_.powers().empty()) return;
  for (std::size_t i = 0; i < value_.powers().size(); i += 4)
    for (const ChebyshevSeries* series : {&value_, &slope_, &curvature_})
      for (std::size_t j = i; j < i + 4; ++j)
        blocks_.push_back(j < series->powers().size() ? series->powers()[j] : 0.0);
}

ReferenceCurve::ReferenceCurve(CubicSpline spline, Interval domain)
    : ReferenceCurve(Basis::chebyshev, {0.0}, domain) {
  check_numbers(spline.coefficients(), domain);
  if (spline.knots().front() < domain.lo || spline.knots().back() > domain.hi)
    refuse("spline knots from ", spline.knots().front(), " to ", spline.knots().back(),
           ", expected knots in [", domain.lo, ", ", domain.hi, "]");
  spline_ = std::move(spline);
}

double ReferenceCurve::third_derivative_bound() const {
  if (spline_) {
    const bool bends = spline_->knots().front() > domain_.lo || spline_->knots().back() < domain_.hi;
    return bends ? std::numeric_limits<double>::infinity() : spline_->third_derivative_bound();
  }
  const ChebyshevSeries third = curvature_.derivative(ds_dv_);
  double sum = 0.0;  // a bound, because each Chebyshev polynomial is within -1 and 1
  for (const double c : third.coefficients()) sum += std::abs(c);
  return sum;
}

const std::vector<double>& ReferenceCurve::knots() const {
  static const std::vector<double> none;
  return spline_ ? spline_->knots() : none;
}

ReferenceCurve ReferenceCurve::with(const std::vector<double>& coefficients) const {
  if (spline_) return {CubicSpline(spline_->knots(), coefficients), domain_};
  return {Basis::chebyshev, coefficients, domain_};
}

// The grid is evenly spaced in F(v), which rises from 0 to 1. F is the mean of two functions: one is linear
// in v, and the other rises by the same amount in each piece of the spline. Short pieces therefore get enough
// points.
std::vector<double> grid_of(Interval range, const std::vector<double>& knots, std::size_t steps) {
  std::vector<double> inputs{range.lo}, share{0.0};
  const double pieces = knots.empty() ? 0.0 : static_cast<double>(knots.size() - 1);
  const auto add = [&](double v, double passed) {
    if (!(v > inputs.back())) return;
    const double even = (v - range.lo) / range.span();
    inputs.push_back(v);
    share.push_back(pieces > 0.0 ? 0.5 * even + 0.5 * passed / pieces : even);
  };
  for (std::size_t i = 0; i < knots.size(); ++i)
    if (knots[i] < range.hi) add(knots[i], static_cast<double>(i));
  add(range.hi, pieces);
  std::vector<double> grid{range.lo};
  std::size_t after = 1;
  for (std::size_t i = 1; i < steps; ++i) {
    const double wanted = static_cast<double>(i) / static_cast<double>(steps);
    while (after + 1 < share.size() && share[after] < wanted) ++after;
    const double part = (wanted - share[after - 1]) / (share[after] - share[after - 1]);
    grid.push_back(inputs[after - 1] + part * (inputs[after] - inputs[after - 1]));
  }
  grid.push_back(range.hi);
  return grid;
}

}  // namespace hystcan::model
