#include "model/prandtl_ishlinskii.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/model/plays.h"
#include "tests/model/saved_text.h"
#include "tests/support/refusal.h"

namespace hystcan::model::prandtl_ishlinskii_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// 0..100 V, about 30 um. The second weight is negative:
//   W = 0.2, 0.25, 0.24, 0.3 um/V
PrandtlIshlinskiiParameters stage() {
  return {"V", "um", {0.0, 100.0}, 1.5, 0.2, {5.0, 15.0, 30.0}, {0.05, -0.01, 0.06}};
}

std::string refusal_of(const PrandtlIshlinskiiParameters& parameters) {
  return support::refusal_of<std::invalid_argument>([&] { const PrandtlIshlinskii model(parameters); });
}

std::string refusal_of(double input, const std::vector<double>& plays) {
  return support::refusal_of<std::invalid_argument>(
      [&] { PrandtlIshlinskii(stage()).restore(input, plays); });
}

// Manual calculation: each play rests until the input drags it.
TEST(PrandtlIshlinskii, IsTheSumOfItsPlays) {
  const PrandtlIshlinskii model(stage());
  PlayState state = model.virgin(0.0);
  EXPECT_DOUBLE_EQ(state.output, 1.5);
  EXPECT_DOUBLE_EQ(model.advance(state, 20.0).value, 1.5 + 0.2 * 20 + 0.05 * 15 - 0.01 * 5);
  EXPECT_DOUBLE_EQ(model.advance(state, 12.0).value, 1.5 + 0.2 * 12 + 0.05 * 15 - 0.01 * 5);
  EXPECT_DOUBLE_EQ(model.advance(state, 100.0).value, 1.5 + 0.2 * 100 + 0.05 * 95 - 0.01 * 85 + 0.06 * 70);
  EXPECT_DOUBLE_EQ(model.advance(state, 60.0).value, 1.5 + 0.2 * 60 + 0.05 * 65 - 0.01 * 75 + 0.06 * 70);
  EXPECT_EQ(state.plays, (std::vector{65.0, 75.0, 70.0}));
}

TEST(PrandtlIshlinskii, StartsWithEveryPlayCentred) {
  const PrandtlIshlinskii model(stage());
  EXPECT_EQ(model.virgin(40.0).plays, (std::vector{40.0, 40.0, 40.0}));
  EXPECT_EQ(model.virgin(40.0).input, 40.0);
}

// Because v + r is rounded, a play can start to move an ulp away from v. An inverse that moves to the present
// output would multiply this error by 10 = W_0 / W_1.
TEST(PrandtlIshlinskii, InvertsThePresentOutputToTheBitWithAPlayAtItsEdge) {
  const PrandtlIshlinskii model({"V", "um", {-1.0, 1.0}, 0.0, 1.0, {0.3}, {-0.9}});
  for (int i = -600; i < 600; ++i) {
    const PlayState state = after(model, {1.0, i / 1000.0});
    EXPECT_EQ(model.inverse(state, state.output).value, state.input);
  }
}

TEST(PrandtlIshlinskii, ReplacesInputsOutsideItsRangeByTheEdge) {
  const PrandtlIshlinskii model(stage());
  PlayState state = model.virgin(50.0);
  const Interval reach = model.reachable(state);
  EXPECT_TRUE(model.forward(state, -1.0).saturated);
  EXPECT_EQ(model.forward(state, -1.0).value, reach.lo);
  EXPECT_FALSE(model.forward(state, 100.0).saturated);
  EXPECT_TRUE(model.advance(state, 101.0).saturated);
  EXPECT_EQ(state.input, 100.0);
  EXPECT_EQ(state.output, reach.hi);
}

TEST(PrandtlIshlinskii, ReplacesOutputsOutOfReachByTheEdge) {
  const PrandtlIshlinskii model(stage());
  const PlayState state = model.virgin(50.0);
  const Interval reach = model.reachable(state);
  for (const double beyond : {reach.hi + 1.0, std::nextafter(reach.hi, infinity)}) {
    EXPECT_TRUE(model.inverse(state, beyond).saturated);
    EXPECT_EQ(model.inverse(state, beyond).value, 100.0);
  }
  EXPECT_TRUE(model.inverse(state, std::nextafter(reach.lo, -infinity)).saturated);
  EXPECT_EQ(model.inverse(state, reach.lo - 1.0).value, 0.0);
  EXPECT_FALSE(model.inverse(state, reach.hi).saturated);
  EXPECT_FALSE(model.inverse(state, reach.lo).saturated);
}

TEST(PrandtlIshlinskii, KeepsItsMemoryWhenTheInputIsNotFinite) {
  const PrandtlIshlinskii model(stage());
  PlayState state = after(model, {0.0, 80.0, 30.0});
  const PlayState before = state;
  for (const double bad : {nan, infinity, -infinity}) {
    EXPECT_TRUE(std::isnan(model.forward(state, bad).value));
    EXPECT_TRUE(std::isnan(model.inverse(state, bad).value));
    EXPECT_EQ(model.advance(state, bad).value, before.output);
    EXPECT_FALSE(model.forward(state, bad).finite);
    EXPECT_FALSE(model.inverse(state, bad).finite);
    EXPECT_FALSE(model.advance(state, bad).finite);
  }
  EXPECT_TRUE(same_bits(state, before));
  EXPECT_TRUE(model.forward(state, 50.0).finite);
}

TEST(PrandtlIshlinskii, SavesItsMemoryAsToml) {
  const PrandtlIshlinskii model({"V", "um", {0.0, 10.0}, 1.0, 2.0, {1.0, 2.5}, {0.5, 0.5}});
  const PlayState state = after(model, {0.0, 4.0, 3.5});
  std::array<char, 500> room{};
  const std::string text(model.save(state, room));
  EXPECT_EQ(text.substr(0, 37), "[memory]\nkind = \"prandtl-ishlinskii\"\n");
  EXPECT_EQ(text.substr(text.find("input")), "input = 3.5\noutput = 10.25\nplays = [3.0, 1.5]\n");
}

TEST(PrandtlIshlinskii, SavesNothingIfTheBufferIsTooSmall) {
  const PrandtlIshlinskii model(stage());
  std::array<char, 60> room{};
  EXPECT_TRUE(model.save(model.virgin(50.0), room).empty());
}

TEST(PrandtlIshlinskii, HasAFingerprintOfAllItsParameters) {
  const std::uint64_t print = PrandtlIshlinskii(stage()).fingerprint();
  EXPECT_EQ(PrandtlIshlinskii(stage()).fingerprint(), print);
  const auto differs = [&](auto change) {
    PrandtlIshlinskiiParameters p = stage();
    change(p);
    return PrandtlIshlinskii(p).fingerprint() != print;
  };
  EXPECT_TRUE(differs([](auto& p) { p.input_unit = "A"; }));
  EXPECT_TRUE(differs([](auto& p) { p.output_unit = "mm"; }));
  EXPECT_TRUE(differs([](auto& p) { p.input_range.hi = 101.0; }));
  EXPECT_TRUE(differs([](auto& p) { p.offset = 1.6; }));
  EXPECT_TRUE(differs([](auto& p) { p.gain = 0.21; }));
  EXPECT_TRUE(differs([](auto& p) { p.thresholds[1] = 15.1; }));
  EXPECT_TRUE(differs([](auto& p) { p.weights[2] = 0.07; }));
}

TEST(PrandtlIshlinskii, NamesTheParameterThatItRefuses) {
  const auto refusal = [](auto change) {
    PrandtlIshlinskiiParameters p = stage();
    change(p);
    return refusal_of(p);
  };
  EXPECT_EQ(refusal([](auto&) {}), "accepted");
  EXPECT_EQ(refusal([](auto& p) {
              p.input_range = {5.0, 5.0};
            }),
            "input_range [5, 5], expected finite lo < hi");
  EXPECT_EQ(refusal([](auto& p) { p.offset = nan; }), "offset = nan, expected a finite number");
  EXPECT_EQ(refusal([](auto& p) { p.gain = 0.0; }), "gain = 0, expected a positive number");
  EXPECT_EQ(refusal([](auto& p) { p.weights.pop_back(); }), "2 weights, expected 3");
  EXPECT_EQ(refusal([](auto& p) { p.thresholds[0] = 0.0; }), "thresholds[0] = 0, expected more than 0");
  EXPECT_EQ(refusal([](auto& p) { p.thresholds[2] = 15.0; }), "thresholds[2] = 15, expected more than 15");
  EXPECT_EQ(refusal([](auto& p) { p.thresholds[1] = nan; }), "thresholds[1] = nan, expected a finite number");
  EXPECT_EQ(refusal([](auto& p) { p.weights[1] = infinity; }), "weights[1] = inf, expected a finite number");
  EXPECT_EQ(refusal([](auto& p) { p.weights[1] = -0.5; }),
            "gain + ... + weights[1] = -0.25, expected a positive sum, more than 1e-12 of the sum of the "
            "absolute values");
}

// In floating point, 0.1 + 0.2 - 0.3 is 6e-17.
TEST(PrandtlIshlinskii, RefusesASlopeWithinRounding) {
  PrandtlIshlinskiiParameters p = stage();
  p.gain = 0.1;
  p.weights = {0.2, -0.3, 1.0};
  EXPECT_NE(refusal_of(p), "accepted");
}

TEST(PrandtlIshlinskii, RefusesAStartOutsideItsRange) {
  const PrandtlIshlinskii model(stage());
  for (const double outside : {-0.1, 100.1, nan, infinity})
    EXPECT_THROW(model.virgin(outside), std::invalid_argument);
}

TEST(PrandtlIshlinskii, RefusesToRestoreAMemoryOfAnotherModel) {
  EXPECT_EQ(refusal_of(50.0, {45.0, 35.0, 20.0}), "accepted");
  EXPECT_EQ(refusal_of(50.0, {45.0, 35.0}), "2 plays, expected 3");
  EXPECT_EQ(refusal_of(50.0, {45.0, nan, 20.0}), "plays[1] = nan, expected within 10 of 45");
  EXPECT_EQ(refusal_of(50.0, {45.0, 35.0, infinity}), "plays[2] = inf, expected within 15 of 35");
  EXPECT_EQ(refusal_of(100.5, {96.0, 90.0, 80.0}), "input = 100.5, expected a number from 0 to 100");
  EXPECT_EQ(refusal_of(nan, {45.0, 35.0, 20.0}), "input = nan, expected a number from 0 to 100");
  EXPECT_EQ(refusal_of(50.0, {55.5, 50.0, 50.0}), "plays[0] = 55.5, expected within 5 of 50");
  EXPECT_EQ(refusal_of(50.0, {45.0, 35.0, 19.5}), "plays[2] = 19.5, expected within 15 of 35");
}

// Each play is within its threshold of the input, but no input separates two plays by this much.
TEST(PrandtlIshlinskii, RefusesToRestorePlaysThatAreNotNested) {
  EXPECT_EQ(refusal_of(50.0, {55.0, 36.0, 50.0}), "plays[1] = 36, expected within 10 of 55");
}

TEST(PrandtlIshlinskii, AcceptsRoundingErrorsInARestoredMemory) {
  const PrandtlIshlinskii model(stage());
  const PlayState state = model.restore(50.0, std::vector{45.0 - 5e-11, 35.0, 20.0});
  EXPECT_EQ(state.plays[0], 45.0);
}

}  // namespace
}  // namespace hystcan::model::prandtl_ishlinskii_test
