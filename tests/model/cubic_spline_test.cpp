#include "model/cubic_spline.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "model/reference_curve.h"
#include "tests/model/models.h"

namespace hystcan::model::cubic_spline_test {
namespace {

struct Drawn {
  std::vector<double> knots, coefficients;

  static Drawn draw() {
    Drawn drawn;
    drawn.knots.push_back(*number(-100.0, 100.0));
    const int pieces = *rc::gen::inRange(1, 40);
    for (int i = 0; i < pieces; ++i)
      drawn.knots.push_back(drawn.knots.back() + std::pow(10.0, *number(-2.0, 2.0)));
    for (int i = 0; i < pieces + 3; ++i) drawn.coefficients.push_back(*number(-1.0, 1.0));
    return drawn;
  }
  double place() const {
    const double span = knots.back() - knots.front();
    return knots.front() - 0.1 * span + 1.2 * span * *number(0.0, 1.0);
  }
};

TEST(BSplines, SumToOneEverywhere) {
  EXPECT_TRUE(rc::check("values sum to 1, derivatives to 0", [] {
    const Drawn drawn = Drawn::draw();
    const BSplines row = bsplines(drawn.knots, drawn.place());
    double value = 0.0, slope = 0.0, largest = 0.0;
    for (const Jet& at : row.at) {
      value += at.value;
      slope += at.slope;
      largest = std::max(largest, std::abs(at.value) + std::abs(at.slope));
    }
    RC_ASSERT(std::abs(value - 1.0) <= 1e-14 * (1.0 + largest));
    RC_ASSERT(std::abs(slope) <= 1e-13 * (1.0 + largest));
  }));
}

TEST(CubicSpline, IsTheSumOfItsBSplines) {
  EXPECT_TRUE(rc::check("value, slope and curvature", [] {
    const Drawn drawn = Drawn::draw();
    const CubicSpline spline(drawn.knots, drawn.coefficients);
    const double v = drawn.place();
    Jet sum, size;
    const BSplines row = bsplines(drawn.knots, v);
    for (std::size_t i = 0; i < row.at.size(); ++i) {
      const double c = drawn.coefficients[row.first + i];
      sum = {sum.value + c * row.at[i].value, sum.slope + c * row.at[i].slope,
             sum.curvature + c * row.at[i].curvature};
      size = {size.value + std::abs(row.at[i].value), size.slope + std::abs(row.at[i].slope),
              size.curvature + std::abs(row.at[i].curvature)};
    }
    const Jet found = spline.jet(v);
    RC_ASSERT(std::abs(found.value - sum.value) <= 1e-12 * size.value);
    RC_ASSERT(std::abs(found.slope - sum.slope) <= 1e-11 * size.slope);
    RC_ASSERT(std::abs(found.curvature - sum.curvature) <= 1e-10 * (size.curvature + 1e-300));
    RC_ASSERT(spline.value(v) == found.value);
    RC_ASSERT(spline.slope(v) == found.slope);
    RC_ASSERT(spline.curvature(v) == found.curvature);
  }));
}

TEST(CubicSpline, HasAContinuousCurvatureBetweenItsKnots) {
  const CubicSpline spline({0.0, 1.0, 1.5, 4.0}, {0.0, 1.0, -1.0, 2.0, 0.5, 3.0});
  for (const double knot : {1.0, 1.5}) {
    const Jet before = spline.jet(std::nextafter(knot, 0.0)), after = spline.jet(knot);
    EXPECT_NEAR(before.value, after.value, 1e-14);
    EXPECT_NEAR(before.slope, after.slope, 1e-13);
    EXPECT_NEAR(before.curvature, after.curvature, 1e-12);
  }
}

TEST(CubicSpline, ContinuesOnItsTangentsBeyondTheKnots) {
  const CubicSpline spline({0.0, 1.0, 1.5, 4.0}, {0.0, 1.0, -1.0, 2.0, 0.5, 3.0});
  EXPECT_DOUBLE_EQ(spline.value(-2.0), 0.0 - 2.0 * spline.slope(0.0));
  EXPECT_DOUBLE_EQ(spline.value(6.0), 3.0 + 2.0 * spline.slope(4.0));
  EXPECT_EQ(spline.curvature(-1.0), 0.0);
  EXPECT_EQ(spline.curvature(5.0), 0.0);
}

TEST(CubicSpline, IsALineForGrevillePointsAsCoefficients) {
  const std::vector<double> knots{-2.0, 0.0, 0.1, 7.0};
  const CubicSpline line(knots, greville_points(knots));
  for (const double v : {-5.0, -2.0, -0.3, 0.05, 3.0, 7.0, 9.0}) EXPECT_NEAR(line.value(v), v, 1e-14 * 9.0);
}

TEST(CubicSpline, RefusesKnotsThatDoNotIncreaseAndAWrongNumberOfCoefficients) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto made = [](const std::vector<double>& knots, std::size_t coefficients) {
    return CubicSpline(knots, std::vector<double>(coefficients, 1.0));
  };
  EXPECT_THROW(made({}, 2), std::invalid_argument);
  EXPECT_THROW(made({1.0}, 3), std::invalid_argument);
  EXPECT_THROW(made({1.0, 1.0}, 4), std::invalid_argument);
  EXPECT_THROW(made({1.0, 0.0}, 4), std::invalid_argument);
  EXPECT_THROW(made({0.0, nan, 1.0}, 5), std::invalid_argument);
  EXPECT_THROW(made({-1e308, 1e308}, 4), std::invalid_argument);
  EXPECT_THROW(made({0.0, 1.0}, 3), std::invalid_argument);
  EXPECT_THROW(made({0.0, 1.0}, 5), std::invalid_argument);
}

TEST(ReferenceCurve, RefusesASplineWithKnotsOutsideItsInterval) {
  const CubicSpline spline({0.0, 1.0}, {0.0, 1.0, 2.0, 3.0});
  EXPECT_NO_THROW(ReferenceCurve(spline, {-1.0, 1.0}));
  EXPECT_THROW(ReferenceCurve(spline, {0.5, 1.0}), std::invalid_argument);
  EXPECT_THROW(ReferenceCurve(spline, {0.0, 0.5}), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::model::cubic_spline_test
