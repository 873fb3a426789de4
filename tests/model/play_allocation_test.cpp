// This is a separate program, because its operator new counts allocations.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>

#include "model/creep.h"
#include "model/output_creep.h"
#include "model/prandtl_ishlinskii.h"
#include "tests/support/count_allocations.h"

namespace hystcan::model::play_allocation_test {
namespace {

TEST(PlayAllocation, NeverHappensInForwardInverseAdvanceOrSave) {
  const PrandtlIshlinskii model({"V", "um", {0.0, 100.0}, 1.5, 0.2, {5.0, 15.0, 30.0}, {0.05, -0.01, 0.06}});
  PlayState state = model.virgin(0.0);
  std::array<char, 1000> text{};
  const std::uint64_t before = support::allocations_so_far();
  double sum = 0.0;
  for (const double v : {0.0, 100.0, 30.0, 200.0, -5.0, 60.0, 40.0}) {
    sum += model.forward(state, v).value + model.reachable(state).span();
    sum += model.inverse(state, 0.3 * v).value;
    sum += model.advance(state, v).value;
    sum += static_cast<double>(model.save(state, text).size());
  }
  const std::uint64_t after = support::allocations_so_far();
  EXPECT_EQ(after, before);
  EXPECT_GT(sum, 0.0);
}

TEST(PlayAllocation, NeverHappensInAStepOfCreep) {
  const Creep::Operators config = logarithmic_creep(0.01, 0.1, 1000.0);
  const Creep step(config, 0.01);
  Creep::State state = Creep::settled(config, 0.0);
  const std::uint64_t before = support::allocations_so_far();
  double sum = 0.0;
  for (const double u : {1.0, 100.0, 30.0}) sum += step(state, u);
  const std::uint64_t after = support::allocations_so_far();
  EXPECT_EQ(after, before);
  EXPECT_GT(sum, 0.0);
}

TEST(PlayAllocation, NeverHappensInLaterRowsOfHeldCreep) {
  HeldCreep creep{OutputCreep({.per_decade = 0.02})};
  creep.follow(1.0);
  const std::uint64_t before = support::allocations_so_far();
  double sum = 0.0;
  for (const double time_s : {1.0, 3.0, 3.5}) {
    creep.hold_until(time_s);
    sum += creep.follow(creep.inverse(10.0 * time_s));
  }
  const std::uint64_t after = support::allocations_so_far();
  EXPECT_EQ(after, before);
  EXPECT_GT(sum, 0.0);
}

}  // namespace
}  // namespace hystcan::model::play_allocation_test
