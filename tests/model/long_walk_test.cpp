// The properties of the model over walks as long as a weekend: 100 000 steps, or a million setpoints in the
// long run.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

#include "model/hysteresis.h"
#include "model/validity.h"
#include "tests/model/models.h"
#include "tests/model/oracle.h"

namespace hystcan::model::long_walk_test {
namespace {

TEST(LongWalk, AgreesWithThePaperOverAHundredThousandSteps) {
  std::size_t deepest = 0;
  EXPECT_TRUE(rc::check("the output at five hundred places agrees with the whole history before it", [&] {
    const Hysteresis model(RandomModel::draw());
    const auto walk = long_walk(model.input_range(), 100'000, *rc::gen::arbitrary<std::uint32_t>());
    HysteresisState state = model.virgin(walk[0], 1000);
    Oracle oracle(model.parameters(), Oracle::Start::virgin, walk[0]);
    for (std::size_t i = 1; i < walk.size(); ++i) {
      const double reached = model.advance(state, walk[i]).value;
      oracle.drive(walk[i]);
      deepest = std::max(deepest, state.depth());
      if (i % 200 == 0)
        RC_ASSERT(std::abs(reached - static_cast<double>(oracle.output())) <=
                  1e-13 * model.output_range().span());
    }
    RC_ASSERT(state.merged == 0u);
  }));
  EXPECT_GT(deepest, 15u);
}

TEST(LongWalk, AgreesWithThePaperForEveryKUpToAHundredThousandPerSpan) {
  EXPECT_TRUE(rc::check("the equations also hold beyond the limit, where a branch goes the wrong way", [] {
    const Hysteresis model = Hysteresis::beyond_limit(RandomModel::draw_beyond_limit());
    const auto walk = long_walk(model.input_range(), 150, *rc::gen::arbitrary<std::uint32_t>());
    HysteresisState state = model.at_lower_threshold();
    Oracle oracle(model.parameters(), Oracle::Start::lower, state.input);
    for (const double v : walk)
      RC_ASSERT(std::abs(model.advance(state, v).value - static_cast<double>(oracle.advance(v))) <=
                1e-13 * model.output_range().span());
  }));
}

TEST(LongWalk, InvertsEverySetpointAndRemembersTheReturnedInputs) {
  int cases = 0, setpoints = 0, not_increasing = 0;
  EXPECT_TRUE(rc::check("round trip within 1e-13 of span", [&] {
    ++cases;
    const Hysteresis model(RandomModel::draw());
    const Interval reach = model.output_range();
    HysteresisState inverted = model.at_lower_threshold(1000), driven = inverted;
    for (const double x : long_walk(reach, 10'000, *rc::gen::arbitrary<std::uint32_t>())) {
      const Prediction drive = model.inverse(inverted, x);
      const Prediction reached = model.advance(inverted, drive.value);
      model.advance(driven, drive.value);
      ++setpoints;
      RC_ASSERT(!drive.saturated);
      if (drive.increasing)
        RC_ASSERT(std::abs(reached.value - x) <= 1e-13 * reach.span());
      else
        ++not_increasing;
      RC_ASSERT(inverted.output == driven.output && inverted.depth() == driven.depth());
    }
    RC_ASSERT(std::ranges::equal(inverted.branches, driven.branches, {}, &Branch::coefficient,
                                 &Branch::coefficient));
  }));
  EXPECT_GE(setpoints, 10'000 * cases);
  EXPECT_LE(not_increasing, setpoints / 1000);
}

// The scan checks two reversals on a grid of 200; loops can be nested deeper and between the grid points. At
// the limit, slopes of about -1e-5 of the mean slope therefore remain, in one step of ten thousand.
TEST(LongWalk, StaysWithinTheGridErrorOfTheScanAtTheLimitOfK) {
  int steps = 0, flagged = 0;
  EXPECT_TRUE(rc::check("slopes at every reversal", [&] {
    HysteresisParameters p = RandomModel::draw();
    const double span = p.ascending.domain().span();
    for (const Direction way : {Direction::ascending, Direction::descending}) {
      const auto allowed = allowed_k(p, way);
      RC_ASSERT(allowed.has_value());
      (way == Direction::ascending ? p.k_ascending : p.k_descending) = std::min(allowed->hi, 200.0 / span);
    }
    const Hysteresis model(p);
    const double mean_slope = model.output_range().span() / span;
    HysteresisState state = model.at_lower_threshold();
    for (const double v : long_walk(model.input_range(), 2000, *rc::gen::arbitrary<std::uint32_t>())) {
      ++steps;
      if (model.advance(state, v).increasing) continue;
      ++flagged;
      const Branch& branch = state.branches.back();
      const bool up = state.direction() == Direction::ascending;
      const double slope = (up ? p.ascending : p.descending).slope(branch.start_input) -
                           sign(state.direction()) * branch.coefficient;
      RC_ASSERT(slope > -2e-4 * mean_slope);
    }
  }));
  EXPECT_LT(flagged, steps / 1000);
}

}  // namespace
}  // namespace hystcan::model::long_walk_test
