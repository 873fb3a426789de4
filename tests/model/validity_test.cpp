#include "model/validity.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "tests/model/models.h"
#include "tests/support/refusal.h"

namespace hystcan::model::validity_test {
namespace {

std::string refusal(const HysteresisParameters& parameters) {
  return support::refusal_of<std::invalid_argument>([&] {
    check_curves(parameters);
    check_branches(parameters);
  });
}

ReferenceCurve curve(std::vector<double> power, Interval range = {0.0, 100.0}) {
  return ReferenceCurve(Basis::power, power, range);
}

TEST(Validity, AcceptsThePiezoAndTheGalfenolModel) {
  EXPECT_EQ(refusal(piezo_model()), "accepted");
  EXPECT_EQ(refusal(galfenol_model()), "accepted");
  EXPECT_EQ(refusal(linear_model(0.0)), "accepted");
  EXPECT_EQ(refusal(linear_model(-0.05)), "accepted");
}

TEST(Validity, NamesTheCurveAndTheIntervalThatDecreases) {
  HysteresisParameters parameters = piezo_model();
  // slope 0.3 - 0.042 v + 0.00126 v^2 < 0 between 10.37 and 22.97 V
  parameters.ascending = curve({0.0, 0.3, -0.021, 0.00042});
  parameters.descending = curve({1.0, 2.39});
  const std::string text = refusal(parameters);
  EXPECT_EQ(text.find("ascending curve decreases between 10.4 and 22.95 V (slope -0.0499"), 0u) << text;
  EXPECT_NE(text.find(" um/V), expected an increasing curve"), std::string::npos) << text;
}

TEST(Validity, RefusesCurvesThatFallCrossOrDoNotMeet) {
  HysteresisParameters parameters = piezo_model();
  parameters.ascending = curve({30.0, -0.3});
  EXPECT_NE(refusal(parameters).find("ascending curve runs from 30 to 0"), std::string::npos);
  parameters = piezo_model();
  std::swap(parameters.ascending, parameters.descending);
  EXPECT_NE(refusal(parameters).find("below the ascending curve at"), std::string::npos);
  parameters = piezo_model();
  parameters.descending = curve({0.8, 0.372, -7.9e-4});
  EXPECT_NE(refusal(parameters).find("expected the curves to meet"), std::string::npos);
  parameters.descending = curve({0.8, 0.372, -8e-4}, {0.0, 99.0});
  EXPECT_NE(refusal(parameters).find("expected the same interval"), std::string::npos);
  parameters = linear_model();
  parameters.descending = curve({20.0, 0.0});
  EXPECT_NE(refusal(parameters), "accepted");
}

TEST(Validity, RefusesAKThatIsNotFiniteOrFarBelowZero) {
  for (const double k :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -3.01}) {
    HysteresisParameters parameters = piezo_model();
    parameters.k_descending = k;
    EXPECT_NE(refusal(parameters).find("k_descending"), std::string::npos) << k;
  }
}

TEST(Validity, RefusesANegativeRangeOfAnEvenModel) {
  HysteresisParameters parameters = linear_model();
  parameters.ascending = curve({0.0, 0.2}, {-100.0, 100.0});
  parameters.descending = curve({0.0, 0.2}, {-100.0, 100.0});
  EXPECT_EQ(refusal(parameters), "accepted");
  parameters.symmetry = Symmetry::even;
  EXPECT_NE(refusal(parameters).find("symmetry"), std::string::npos);
}

// The curves are straight lines with a gap of 1.5 (1 - v / 100) um and a slope of 0.185 um/V. If k is too
// large, a fall from near the top of the branch from L_0 starts too steeply. No step of a model below the
// limit may be flagged.
TEST(Validity, FindsALimitOfKBelowWhichAllLoopsIncrease) {
  double valid = 0.05, refused = 5.0;
  while (refused - valid > 1e-4) {
    const double k = 0.5 * (valid + refused);
    (refusal(linear_model(k)) == "accepted" ? valid : refused) = k;
  }
  EXPECT_NE(refusal(linear_model(refused)).find("branch from"), std::string::npos);
  EXPECT_NE(refusal(linear_model(refused)).find("is too large"), std::string::npos);

  const Hysteresis model(linear_model(valid));
  for (int high = 5; high < 100; high += 5) {
    for (int low = 1; low < high; low += 3) {
      HysteresisState state = model.at_lower_threshold();
      EXPECT_TRUE(model.advance(state, high).increasing);
      EXPECT_TRUE(model.advance(state, low).increasing) << high << " to " << low;
      EXPECT_TRUE(model.advance(state, low + 0.5 * (high - low)).increasing);
    }
  }
}

// Samples 2000 points along many falling branches; the output must decrease from each point to the next.
TEST(Validity, AcceptedModelsIncreaseAlongTheirBranches) {
  for (HysteresisParameters parameters : {piezo_model(), galfenol_model(), linear_model()}) {
    while (refusal(parameters) == "accepted") parameters.k_ascending *= 1.01, parameters.k_descending *= 1.01;
    parameters.k_ascending /= 1.01, parameters.k_descending /= 1.01;
    const Hysteresis model(parameters);
    const Interval range = model.input_range();
    for (int i = 1; i < 20; ++i) {
      HysteresisState state = model.at_lower_threshold();
      const double high = range.lo + range.span() * i / 20.0;
      model.advance(state, high);
      double before = state.output;
      for (int j = 1; j < 2000; ++j) {
        const double x = model.forward(state, high + (range.lo - high) * j / 2000.0).value;
        EXPECT_LT(x, before);
        before = x;
      }
    }
  }
}

TEST(AllowedK, EndsAtTheLimitOfValidModels) {
  for (const HysteresisParameters& given : {piezo_model(), galfenol_model(), linear_model()}) {
    const double span = given.ascending.domain().span();
    for (const Direction way : {Direction::ascending, Direction::descending}) {
      const auto allowed = allowed_k(given, way);
      ASSERT_TRUE(allowed);
      HysteresisParameters p = given;
      double& k = way == Direction::ascending ? p.k_ascending : p.k_descending;
      EXPECT_TRUE(allowed->contains(k));
      k = allowed->hi;
      EXPECT_EQ(refusal(p), "accepted");
      k = allowed->hi * 1.0001 + 1e-3 / span;
      EXPECT_NE(refusal(p), "accepted");
      k = allowed->lo;
      EXPECT_EQ(refusal(p), "accepted");
      for (const double end : {allowed->lo, allowed->hi}) {
        char six_digits[32];
        std::snprintf(six_digits, sizeof six_digits, "%.6g", end);
        k = std::strtod(six_digits, nullptr);
        EXPECT_EQ(refusal(p), "accepted");
      }
    }
  }
}

TEST(AllowedK, IsInTheMessageIfAModelIsRefused) {
  HysteresisParameters p = piezo_model();
  const double limit = allowed_k(p, Direction::descending)->hi;
  p.k_descending = 0.5;
  const std::string text = refusal(p);
  const auto at = text.find("too large, at most ");
  ASSERT_NE(at, std::string::npos) << text;
  EXPECT_NEAR(std::stod(text.substr(at + 19)), limit, 1e-5 * limit);
}

TEST(AllowedK, IsGivenForBothDirectionsIfOneAloneDoesNotHelp) {
  HysteresisParameters p = piezo_model();
  p.k_ascending = p.k_descending = 0.5;
  const std::string text = refusal(p);
  const auto at = text.find("too large together with ");
  ASSERT_NE(at, std::string::npos) << text;
  const double reported = std::stod(text.substr(text.find("k_ascending = ", at) + 14));
  p.k_ascending = p.k_descending = reported;
  EXPECT_EQ(refusal(p), "accepted");
  p.k_ascending = p.k_descending = reported * (1 + 1e-4);
  EXPECT_NE(refusal(p), "accepted");
}

TEST(AllowedK, IsEmptyIfTheCurvesAloneMakeABranchDecrease) {
  // Both curves are flat at both ends. The branch from L_0 must approach f_A by 10 um and can do so at
  // neither end.
  HysteresisParameters p = linear_model(0.0);
  p.ascending = curve({0.0, 0.0, 90e-4, -60e-6});
  p.descending = curve({10.0, 0.0, 60e-4, -40e-6});
  EXPECT_NE(refusal(p).find("the two curves are too far apart"), std::string::npos) << refusal(p);
  EXPECT_FALSE(allowed_k(p, Direction::ascending));
}

TEST(Validity, AcceptsAnOriginSoFlatThatRoundingHidesTheRise) {
  HysteresisParameters p = linear_model(0.0);
  for (const std::size_t power : {4u, 6u, 8u, 10u}) {
    std::vector<double> c(power + 1, 0.0);
    c.back() = 1.0;
    p.ascending = p.descending = curve(c, {0.0, 1.0});
    EXPECT_EQ(refusal(p), "accepted") << power;
  }
  p.ascending = p.descending = curve({1.0, 0.0}, {0.0, 1.0});
  EXPECT_NE(refusal(p), "accepted");
}

TEST(Validity, NamesTheDirectionAndTheKOfARefusedModel) {
  HysteresisParameters parameters = piezo_model();
  parameters.k_descending = 0.5;
  const std::string text = refusal(parameters);
  EXPECT_EQ(text.find("descending branch from "), 0u) << text;
  EXPECT_NE(text.find("k_descending = 0.5 1/V is too large"), std::string::npos) << text;
  parameters = piezo_model();
  parameters.k_ascending = 0.5;
  EXPECT_EQ(refusal(parameters).find("ascending branch from "), 0u) << refusal(parameters);
}

}  // namespace
}  // namespace hystcan::model::validity_test
