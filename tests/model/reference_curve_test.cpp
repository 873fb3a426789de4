#include "model/reference_curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace hystcan::model::reference_curve_test {
namespace {

TEST(ReferenceCurve, EqualsThePolynomialOfItsPowers) {
  const ReferenceCurve curve(Basis::power, {1.0, -2.0, 3.0}, {-1.0, 3.0});
  for (const double v : {-1.0, -0.3, 0.0, 1.0, 2.75, 3.0}) {
    EXPECT_NEAR(curve.value(v), 1.0 - 2.0 * v + 3.0 * v * v, 1e-14);
    EXPECT_NEAR(curve.slope(v), -2.0 + 6.0 * v, 1e-14);
    EXPECT_NEAR(curve.curvature(v), 6.0, 1e-14);
  }
  EXPECT_EQ(curve.coefficients().size(), 3U);
}

TEST(ReferenceCurve, KeepsGivenChebyshevCoefficients) {
  // T_0, T_1, T_3 = 4 s^3 - 3 s on [0, 4], s = (v - 2) / 2.
  const ReferenceCurve curve(Basis::chebyshev, {1.0, 2.0, 0.0, 0.5}, {0.0, 4.0});
  EXPECT_EQ(curve.coefficients(), (std::vector<double>{1.0, 2.0, 0.0, 0.5}));
  EXPECT_DOUBLE_EQ(curve.value(0.0), 1.0 - 2.0 - 0.5);
  EXPECT_DOUBLE_EQ(curve.value(4.0), 1.0 + 2.0 + 0.5);
  EXPECT_DOUBLE_EQ(curve.value(3.0), 1.0 + 1.0 + 0.5 * (4.0 * 0.125 - 1.5));
  EXPECT_DOUBLE_EQ(curve.slope(3.0), (2.0 + 0.5 * (12.0 * 0.25 - 3.0)) / 2.0);
  EXPECT_DOUBLE_EQ(curve.curvature(3.0), 0.5 * 24.0 * 0.5 / 4.0);
}

TEST(ReferenceCurve, IsExactToRoundingForOrderTenOverAHundredVolts) {
  std::vector<double> power{0.5};
  for (int j = 1; j <= 10; ++j) power.push_back((j % 2 == 0 ? -1.0 : 1.0) * std::pow(100.0, -j) * (3.0 + j));
  const ReferenceCurve curve(Basis::power, power, {0.0, 100.0});
  double scale = 0.0;  // of the rounding of a Chebyshev series
  for (const double c : curve.coefficients()) scale += std::abs(c);
  for (int i = 0; i <= 1000; ++i) {
    const long double v = 0.1L * i;
    long double exact = 0;
    for (std::size_t j = power.size(); j-- > 0;) exact = exact * v + power[j];
    EXPECT_NEAR(curve.value(static_cast<double>(v)), static_cast<double>(exact),
                scale * 8 * std::numeric_limits<double>::epsilon());
  }
}

TEST(ReferenceCurve, HasTheDerivativesOfItsValueAsSlopeAndCurvature) {
  const ReferenceCurve curve(Basis::chebyshev, {3.0, 2.0, -0.5, 0.25, 0.1, -0.05, 0.02, 0.01, -0.005},
                             {-2.0, 5.0});
  constexpr double h = 1e-4;
  for (const double v : {-1.9, 0.0, 1.3, 4.8}) {
    EXPECT_NEAR(curve.slope(v), (curve.value(v + h) - curve.value(v - h)) / (2 * h), 1e-6);
    EXPECT_NEAR(curve.curvature(v), (curve.slope(v + h) - curve.slope(v - h)) / (2 * h), 1e-6);
  }
}

// Powers of s would lose seven digits of T_20. The bound on their sum detects this, and the recurrence is
// used.
TEST(ReferenceCurve, IsExactToRoundingForOrderTwentyAndMore) {
  for (const int order : {20, 25, 32}) {
    std::vector<double> last(static_cast<std::size_t>(order + 1), 0.0);
    last.back() = 1.0;
    const ReferenceCurve curve(Basis::chebyshev, last, {-1.0, 1.0});
    for (int i = 0; i <= 1000; ++i) {
      const double s = -1.0 + 0.002 * i;
      // The rounding of the angle is multiplied by the order, and by more at the ends.
      const double exact = static_cast<double>(std::cos(order * std::acos(static_cast<long double>(s))));
      EXPECT_NEAR(curve.value(s), exact, 2e-14 * order) << s;
    }
    EXPECT_NEAR(curve.slope(1.0), order * order, 1e-10);
    const Jet end = curve.jet(1.0);
    EXPECT_EQ(end.value, curve.value(1.0));
    EXPECT_EQ(end.slope, curve.slope(1.0));
    EXPECT_EQ(end.curvature, curve.curvature(1.0));
  }
}

TEST(ReferenceCurve, ReturnsValueSlopeAndCurvatureInAJet) {
  for (const std::vector<double>& c :
       {std::vector<double>{1.0}, {1.0, 2.0, 0.1}, {0.0, 3.0, 0.3, 0.1, -0.05}}) {
    const ReferenceCurve curve(Basis::chebyshev, c, {-2.0, 5.0});
    for (const double v : {-2.0, 0.3, 5.0}) {
      EXPECT_DOUBLE_EQ(curve.jet(v).value, curve.value(v));
      EXPECT_DOUBLE_EQ(curve.jet(v).slope, curve.slope(v));
      EXPECT_DOUBLE_EQ(curve.jet(v).curvature, curve.curvature(v));
    }
  }
}

TEST(ReferenceCurve, IsConstantForOrderZero) {
  const ReferenceCurve curve(Basis::power, {7.0}, {0.0, 1.0});
  EXPECT_EQ(curve.value(0.3), 7.0);
  EXPECT_EQ(curve.slope(0.3), 0.0);
  EXPECT_EQ(curve.curvature(0.3), 0.0);
}

TEST(ReferenceCurve, RefusesInvalidCoefficientsOrIntervals) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto make = [](std::vector<double> c, Interval range) { ReferenceCurve(Basis::power, c, range); };
  EXPECT_THROW(make({}, {0.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(make(std::vector<double>(34, 1.0), {0.0, 1.0}), std::invalid_argument);
  EXPECT_NO_THROW(make(std::vector<double>(33, 1.0), {0.0, 1.0}));
  EXPECT_THROW(make({0.0, nan}, {0.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(make({0.0, 1.0}, {1.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(make({0.0, 1.0}, {2.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(make({0.0, 1.0}, {nan, 1.0}), std::invalid_argument);
  EXPECT_THROW(make({0.0, 1e300, 1e300}, {0.0, 1e300}), std::invalid_argument);
}

TEST(ThirdDerivativeBound, IsNotExceeded) {
  const Interval range{0.0, 3.0};
  const std::vector<double> knots{0.0, 0.4, 1.1, 2.5, 3.0};
  for (const ReferenceCurve& curve :
       {ReferenceCurve(Basis::power, {0.0, 4.0, 14.0, -6.0, 0.9}, range),
        ReferenceCurve(CubicSpline(knots, {0.0, 1.0, 3.0, 4.0, 9.0, 9.5, 10.0}), range)}) {
    double largest = 0.0;
    for (double v = 0.01; v < 2.99; v += 0.01)
      largest = std::max(largest, std::abs(curve.curvature(v + 0.005) - curve.curvature(v - 0.005)) / 0.01);
    EXPECT_LE(largest, curve.third_derivative_bound() * (1.0 + 1e-9));
    EXPECT_GT(largest, 0.3 * curve.third_derivative_bound());
  }
}

TEST(ThirdDerivativeBound, IsInfiniteIfASplineEndsInsideTheInterval) {
  const ReferenceCurve curve(CubicSpline({0.5, 1.0, 2.0}, {0.0, 1.0, 2.0, 4.0, 5.0}), {0.0, 2.0});
  EXPECT_TRUE(std::isinf(curve.third_derivative_bound()));
}

}  // namespace
}  // namespace hystcan::model::reference_curve_test
