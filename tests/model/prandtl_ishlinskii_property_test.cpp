#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "tests/model/plays.h"
#include "tests/model/saved_text.h"

namespace hystcan::model::prandtl_ishlinskii_property_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Tolerance: rounding of a sum of 14 terms as large as the output. The span is at least a 20th of the output.
TEST(PrandtlIshlinskiiProperty, ReturnsTheOutputAfterInverseAndForward) {
  EXPECT_TRUE(rc::check("for any reachable output and any memory, to 1e-12 of the reach", [] {
    const PrandtlIshlinskii model(random_plays());
    const PlayState state = random_state(model);
    const Interval reach = model.reachable(state);
    for (int i = 0; i < 20; ++i) {
      const double output = std::clamp(*number(reach.lo, reach.hi), reach.lo, reach.hi);
      const Prediction input = model.inverse(state, output);
      RC_ASSERT(!input.saturated && input.finite && input.increasing);
      RC_ASSERT(model.input_range().contains(input.value));
      RC_ASSERT(std::abs(model.forward(state, input.value).value - output) <= 1e-12 * reach.span());
    }
  }));
}

// Tolerance: as above, divided by a slope of at least a 20th.
TEST(PrandtlIshlinskiiProperty, ReturnsTheInputAfterForwardAndInverse) {
  EXPECT_TRUE(rc::check("for any input, to 1e-12 of the range", [] {
    const PrandtlIshlinskii model(random_plays());
    const PlayState state = random_state(model);
    for (const double v : random_walk(model.input_range(), 20)) {
      const double back = model.inverse(state, model.forward(state, v).value).value;
      RC_ASSERT(std::abs(back - v) <= 1e-12 * model.input_range().span());
    }
  }));
}

TEST(PrandtlIshlinskiiProperty, InvertsThePresentOutputToThePresentInputToTheBit) {
  EXPECT_TRUE(rc::check("for any memory", [] {
    const PrandtlIshlinskii model(random_plays());
    const PlayState state = random_state(model);
    RC_ASSERT(model.inverse(state, state.output).value == state.input);
    RC_ASSERT(!model.inverse(state, state.output).saturated);
  }));
}

TEST(PrandtlIshlinskiiProperty, HasAnIncreasingInverse) {
  EXPECT_TRUE(rc::check("a higher output never needs a lower input, apart from rounding", [] {
    const PrandtlIshlinskii model(random_plays());
    const PlayState state = random_state(model);
    const Interval reach = model.reachable(state);
    double before = model.input_range().lo;
    for (int i = 0; i <= 100; ++i) {
      const double input = model.inverse(state, reach.lo + reach.span() * i / 100).value;
      RC_ASSERT(input >= before - 1e-12 * model.input_range().span());
      before = input;
    }
  }));
}

// The theorem of the header with explicit formulas for r' and w', and plays that follow only the output. The
// sum of w'_i y'_i cancels to a 20th per play; the tolerance is therefore 1e-11.
TEST(PrandtlIshlinskiiProperty, HasAPrandtlIshlinskiiInverse) {
  EXPECT_TRUE(rc::check("the inverse is a model that the outputs drive", [] {
    PrandtlIshlinskiiParameters p = random_plays();
    p.offset = 0.0;  // the inverse's input is x - x_0
    const PrandtlIshlinskii model(p);
    PlayState state = model.virgin(*number(p.input_range.lo, p.input_range.hi));
    PrandtlIshlinskiiParameters q{"um", "V", {-infinity, infinity}, 0.0, 1.0 / p.gain, {}, {}};
    const double total = std::abs(p.input_range.lo) + std::abs(p.input_range.hi);
    double slope = p.gain, threshold = 0.0, at = 0.0;
    for (std::size_t i = 0; i < p.weights.size(); ++i) {
      q.thresholds.push_back(threshold += slope * (p.thresholds[i] - at));
      q.weights.push_back(-p.weights[i] / (slope * (slope + p.weights[i])));
      slope += p.weights[i];
      at = p.thresholds[i];
    }
    const double largest = 20 * slope * total + std::abs(state.output);
    q.input_range = {-largest, largest};
    const PrandtlIshlinskii inverse(q);
    PlayState inverse_state = inverse.virgin(state.output);  // centred plays: y'_i = x
    for (const double share : random_walk({0.0, 1.0}, 30)) {
      const Interval reach = model.reachable(state);
      const double output = reach.lo + share * reach.span();
      const double input = model.inverse(state, output).value;
      RC_ASSERT(std::abs(inverse.advance(inverse_state, output).value - input) <= 1e-11 * total);
      model.advance(state, input);
    }
  }));
}

TEST(PrandtlIshlinskiiProperty, ForwardAndAdvanceReturnTheSameOutput) {
  EXPECT_TRUE(rc::check("to the bit", [] {
    const PrandtlIshlinskii model(random_plays());
    PlayState state = random_state(model);
    for (const double v : random_walk(model.input_range(), 30)) {
      const double predicted = model.forward(state, v).value;
      RC_ASSERT(same_bits(predicted, model.advance(state, v).value));
      RC_ASSERT(same_bits(predicted, state.output));
      RC_ASSERT(same_bits(predicted, model.forward(state, v).value));
      RC_ASSERT(state.input == v);
    }
  }));
}

TEST(PrandtlIshlinskiiProperty, WipesOutSmallerExtremesAfterALargerOne) {
  EXPECT_TRUE(rc::check("after a larger extreme the state is the same as without the smaller ones", [] {
    const PrandtlIshlinskii model(random_plays());
    const Interval range = model.input_range();
    PlayState eventful = model.virgin(range.lo), plain = eventful;
    const double top = *number(range.lo, range.hi);
    for (const double v : random_walk({range.lo, top}, 30)) model.advance(eventful, v);
    model.advance(eventful, top);
    model.advance(plain, top);
    RC_ASSERT(same_bits(eventful, plain));
  }));
}

TEST(PrandtlIshlinskiiProperty, ReturnsToTheSameStateAfterAClosedExcursion) {
  EXPECT_TRUE(rc::check("a closed excursion inside the loop leaves output and memory as they were", [] {
    const PrandtlIshlinskii model(random_plays());
    PlayState state = random_state(model);
    const Interval range = model.input_range();
    const double turned = *number(range.lo, state.input);
    model.advance(state, turned);
    const double now = *number(turned, range.hi);
    model.advance(state, now);
    const PlayState before = state;
    for (const double v : random_walk({turned, now}, 20)) model.advance(state, v);
    model.advance(state, now);
    RC_ASSERT(same_bits(state, before));
  }));
}

TEST(PrandtlIshlinskiiProperty, DoesNotDependOnTheSizeOfTheSteps) {
  EXPECT_TRUE(rc::check("one step gives the same as eleven smaller steps, to the bit", [] {
    const PrandtlIshlinskii model(random_plays());
    const auto walk = random_walk(model.input_range(), 30);
    PlayState big = model.virgin(walk[0]), small = big;
    for (const double v : walk) {
      const double from = small.input;
      for (int i = 1; i <= 10; ++i) model.advance(small, from + (v - from) * i / 11.0);
      model.advance(small, v);
      model.advance(big, v);
      RC_ASSERT(same_bits(small, big));
    }
  }));
}

TEST(PrandtlIshlinskiiProperty, IsRestoredFromItsTextToTheBit) {
  EXPECT_TRUE(rc::check("saved, parsed and restored", [] {
    const PrandtlIshlinskii model(random_plays());
    const PlayState state = random_state(model);
    std::array<char, 1000> room{};
    const std::string text(model.save(state, room));
    const PlayState back = model.restore(number_of(text, "input"), numbers_of(text, "plays"));
    RC_ASSERT(same_bits(back, state));
    RC_ASSERT(same_bits(number_of(text, "output"), state.output));
  }));
}

}  // namespace
}  // namespace hystcan::model::prandtl_ishlinskii_property_test
