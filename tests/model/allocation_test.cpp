// A program of its own: its operator new counts.
#include <gtest/gtest.h>

#include <cstdint>

#include "tests/model/models.h"
#include "tests/support/count_allocations.h"

namespace hystcan::model {
namespace {

TEST(Allocation, IsCounted) {
  const std::uint64_t before = support::allocations_so_far();
  const HysteresisState state = Hysteresis(piezo_model()).virgin(0.0);
  EXPECT_GT(support::allocations_so_far(), before);
}

TEST(Allocation, NeverHappensInForwardInverseOrAdvance) {
  const Hysteresis model(piezo_model());
  HysteresisState state = HysteresisState(model.virgin(0.0, 8));
  const auto walk = nested_swings(model.input_range(), 40);
  const std::uint64_t before = support::allocations_so_far();
  double sum = 0.0;
  for (const double v : walk) {
    sum += model.forward(state, v).value + model.forward(state, 100.0 - v).value;
    sum += model.inverse(state, 0.3 * v).value;
    sum += model.advance(state, v).value;
  }
  for (const double v : {0.0, 100.0, 30.0, 200.0, -5.0}) sum += model.advance(state, v).value;
  const std::uint64_t after = support::allocations_so_far();
  EXPECT_EQ(after, before);
  EXPECT_GT(sum, 0.0);
}

}  // namespace
}  // namespace hystcan::model
