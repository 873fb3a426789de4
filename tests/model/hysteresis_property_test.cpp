#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "model/hysteresis.h"
#include "tests/model/models.h"
#include "tests/model/oracle.h"

namespace hystcan::model::hysteresis_property_test {
namespace {

double span_of(const Hysteresis& model) { return model.output_range().hi - model.output_range().lo; }

TEST(HysteresisProperty, AgreesWithThePaperToRounding) {
  EXPECT_TRUE(rc::check("forward and advance equal the naive recursion", [] {
    const Hysteresis model(RandomModel::draw());
    const auto walk = random_walk(model.input_range(), 40);
    const auto start = *rc::gen::element(Oracle::Start::virgin, Oracle::Start::lower, Oracle::Start::upper);
    HysteresisState state = start == Oracle::Start::virgin  ? model.virgin(walk[0])
                            : start == Oracle::Start::lower ? model.at_lower_threshold()
                                                            : model.at_upper_threshold();
    Oracle oracle(model.parameters(), start, state.input);
    const double tolerance = 1e-12 * span_of(model);
    for (const double v : walk) {
      const double expected = static_cast<double>(oracle.advance(v));
      const double predicted = model.forward(state, v).value;
      const double reached = model.advance(state, v).value;
      RC_ASSERT(predicted == reached);
      RC_ASSERT(std::abs(reached - expected) <= tolerance);
      RC_ASSERT(state.output == reached);
      RC_ASSERT(state.input == v);
    }
  }));
}

TEST(HysteresisProperty, AgreesWithThePaperInDeeplyNestedLoops) {
  EXPECT_TRUE(rc::check("twenty nested turning points, and the way out", [] {
    const Hysteresis model(RandomModel::draw());
    HysteresisState state = model.at_lower_threshold();
    Oracle oracle(model.parameters(), Oracle::Start::lower, state.input);
    std::vector<double> walk = nested_swings(model.input_range(), 20);
    const double centre = walk.back();
    walk.push_back(centre + 0.1 * (walk[walk.size() - 2] - centre));
    walk.push_back(walk[10]);
    walk.push_back(walk[9] + 0.01 * (walk[7] - walk[9]));
    for (const double v : walk)
      RC_ASSERT(std::abs(model.advance(state, v).value - static_cast<double>(oracle.advance(v))) <=
                1e-12 * span_of(model));
    RC_ASSERT(state.depth() == oracle.depth());
  }));
}

TEST(HysteresisProperty, ReturnsToTheSameStateAfterAClosedExcursion) {
  EXPECT_TRUE(rc::check("a closed excursion inside the loop leaves output and memory as they were", [] {
    const Hysteresis model(RandomModel::draw());
    HysteresisState state = model.at_lower_threshold();
    for (const double v : random_walk(model.input_range(), 20)) model.advance(state, v);
    RC_PRE(state.input > model.input_range().lo && state.input < model.input_range().hi);
    const HysteresisState before = state;
    // Moves back and returns, but never past the start of the present branch.
    const double start = state.branches.back().start_input;
    for (const double v : random_walk({std::min(start, state.input), std::max(start, state.input)}, 10))
      if (v != start) model.advance(state, v);
    RC_ASSERT(model.advance(state, before.input).value == before.output);
    const double onward = state.input + 0.5 * (state.input - start);
    RC_PRE(model.input_range().contains(onward));
    RC_ASSERT(model.advance(state, onward).value == model.forward(before, onward).value);
  }));
}

TEST(HysteresisProperty, AlignsWithTheCurveBrokenAtATurningPoint) {
  EXPECT_TRUE(rc::check("the output does not jump where the path passes a target", [] {
    const Hysteresis model(RandomModel::draw());
    const Interval range = model.input_range();
    HysteresisState state = model.at_lower_threshold();
    for (const double v : nested_swings(range, 12)) model.advance(state, v);
    for (std::size_t i = state.depth(); i-- > 0;) {
      const Branch& target = state.branches[i];
      const double before = std::nextafter(target.start_input, state.input);
      const double after = std::nextafter(target.start_input, 2 * target.start_input - state.input);
      const double tolerance = 1e-12 * span_of(model);
      RC_ASSERT(model.forward(state, target.start_input).value == target.start_level);
      RC_ASSERT(std::abs(model.forward(state, before).value - target.start_level) <= tolerance);
      RC_ASSERT(std::abs(model.forward(state, after).value - target.start_level) <= tolerance);
    }
  }));
}

// This holds if k >= 0 and the width of the reference loop is concave. With a negative k the two sides of a
// loop can cross; the equations and the model allow this.
TEST(HysteresisProperty, KeepsInnerLoopsInsideOuterLoops) {
  EXPECT_TRUE(rc::check("between the sides of the surrounding loop, rising below falling", [] {
    const Hysteresis model(RandomModel::draw());
    RC_PRE(model.parameters().k_ascending >= 0.0 && model.parameters().k_descending >= 0.0);
    const Interval range = model.input_range();
    const double slack = 1e-12 * span_of(model);
    HysteresisState state = model.at_lower_threshold();
    const double high = range.lo + range.span() * *number(0.6, 0.95);
    const double low = range.lo + range.span() * *number(0.05, 0.4);
    model.advance(state, high);
    const HysteresisState outer_falling = state;
    model.advance(state, low);
    const HysteresisState outer_rising = state;
    for (const double v : random_walk({low, high}, 30)) {
      const double x = model.advance(state, v).value;
      RC_ASSERT(x >= model.forward(outer_rising, v).value - slack);
      RC_ASSERT(x <= model.forward(outer_falling, v).value + slack);
    }
  }));
}

TEST(HysteresisProperty, IsContinuousWithAFullMemory) {
  EXPECT_TRUE(rc::check("small steps give small changes, forward equals advance", [] {
    const Hysteresis model(RandomModel::draw());
    HysteresisState state = model.at_lower_threshold(4);
    for (const double v : nested_swings(model.input_range(), 9)) model.advance(state, v);
    for (const double v : random_walk(model.input_range(), 20)) {
      const HysteresisState before = state;
      const double nudge = std::nextafter(state.input, v);
      if (model.input_range().contains(nudge))
        RC_ASSERT(std::abs(model.advance(state, nudge).value - before.output) <= 1e-12 * span_of(model));
      RC_ASSERT(model.forward(state, v).value == model.advance(state, v).value);
      RC_ASSERT(state.depth() <= 4u);
    }
  }));
}

}  // namespace
}  // namespace hystcan::model::hysteresis_property_test
