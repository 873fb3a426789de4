#include "model/reference_curve.h"

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace hystcan::model {
namespace {

constexpr std::size_t max_coefficients = 33;

void check(const std::vector<double>& coefficients, const Interval& domain) {
  if (coefficients.empty() || coefficients.size() > max_coefficients)
    throw std::invalid_argument("reference curve has " + std::to_string(coefficients.size()) +
                                " coefficients, expected 1 to " + std::to_string(max_coefficients));
  for (const double c : coefficients)
    if (!std::isfinite(c))
      throw std::invalid_argument("reference curve coefficient is not finite, expected a number");
  if (!std::isfinite(domain.lo) || !std::isfinite(domain.hi) || !(domain.lo < domain.hi) ||
      !std::isfinite(domain.span()))
    throw std::invalid_argument("reference curve interval [" + std::to_string(domain.lo) + ", " +
                                std::to_string(domain.hi) + "], expected finite lo < hi");
}

// Horner's rule on p(centre + radius s), the partial sums held as Chebyshev series: s T_j = (T_{j+1} +
// T_{|j-1|}) / 2.
std::vector<double> from_power(const std::vector<double>& power, const Interval& domain) {
  const long double centre = (static_cast<long double>(domain.lo) + domain.hi) / 2;
  const long double radius = (static_cast<long double>(domain.hi) - domain.lo) / 2;
  const std::size_t n = power.size();
  std::vector<long double> sum(n, 0.0L), next(n, 0.0L);
  for (std::size_t i = n; i-- > 0;) {
    next.assign(n, 0.0L);
    for (std::size_t j = 0; j < n; ++j) {
      next[j] += centre * sum[j];
      if (j + 1 < n) next[j + 1] += radius * (j == 0 ? sum[j] : sum[j] / 2);
      if (j > 0) next[j - 1] += radius * sum[j] / 2;
    }
    next[0] += power[i];
    sum.swap(next);
  }
  return {sum.begin(), sum.end()};
}

// c'_{j-1} = c'_{j+1} + 2 j c_j, c'_0 halved, scaled by ds/dv.
std::vector<double> derivative(const std::vector<double>& c, double ds_dv) {
  const std::size_t n = c.size();
  std::vector<double> d(n + 1, 0.0);
  for (std::size_t j = n - 1; j > 0; --j) d[j - 1] = d[j + 1] + 2.0 * static_cast<double>(j) * c[j];
  d[0] /= 2.0;
  d.resize(n > 1 ? n - 1 : 1);
  for (double& x : d) x *= ds_dv;
  return d;
}

std::vector<double> in_pairs(std::vector<double> c) {
  if (c.size() % 2 == 1) c.push_back(0.0);
  return c;
}

// Clenshaw's recurrence on the even and on the odd terms side by side: with q = T_2(s), T_{j+2} = 2 q T_j -
// T_{j-2} for both, starting from T_{-2} = q and T_{-1} = s.
double clenshaw(const std::vector<double>& pairs, double s) {
  const double two_q = 4.0 * s * s - 2.0;
  Eigen::Array2d b1 = Eigen::Array2d::Zero(), b2 = Eigen::Array2d::Zero();
  const double* c = pairs.data() + pairs.size();
  while (c != pairs.data() + 2) {
    c -= 2;
    const Eigen::Array2d b0 = two_q * b1 + (Eigen::Map<const Eigen::Array2d>(c) - b2);
    b2 = b1;
    b1 = b0;
  }
  const Eigen::Array2d b0 = Eigen::Map<const Eigen::Array2d>(pairs.data()) - b2;
  return (0.5 * two_q * b1[0] + b0[0]) + s * (two_q * b1[1] + b0[1] - b1[1]);
}

}  // namespace

ReferenceCurve::ReferenceCurve(Basis basis, const std::vector<double>& coefficients, Interval domain)
    : domain_(domain) {
  check(coefficients, domain);
  chebyshev_ = basis == Basis::power ? from_power(coefficients, domain) : coefficients;
  for (const double c : chebyshev_)
    if (!std::isfinite(c))
      throw std::invalid_argument("reference curve overflows on its interval, expected smaller coefficients");
  centre_ = domain.lo + domain.span() / 2.0;
  ds_dv_ = 2.0 / domain.span();
  const std::vector<double> slope = derivative(chebyshev_, ds_dv_);
  value_pairs_ = in_pairs(chebyshev_);
  slope_pairs_ = in_pairs(slope);
  curvature_pairs_ = in_pairs(derivative(slope, ds_dv_));
}

double ReferenceCurve::value(double v) const { return clenshaw(value_pairs_, ds_dv_ * (v - centre_)); }
double ReferenceCurve::slope(double v) const { return clenshaw(slope_pairs_, ds_dv_ * (v - centre_)); }
double ReferenceCurve::curvature(double v) const {
  return clenshaw(curvature_pairs_, ds_dv_ * (v - centre_));
}

}  // namespace hystcan::model
