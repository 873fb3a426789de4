// A storm of random faults is identical for the same seed, so that a failure can be reproduced.
#include <gtest/gtest.h>

#include <utility>

#include "tests/support/storm.h"

namespace hystcan::support::repeatable_storm_test {
namespace {

TEST(Storm, RepeatsWithTheSameSeed) {
  const auto faults_of = [](std::uint64_t seed) {
    const StormResult result = run_storm({.seed = seed, .virtual_s = 30.0});
    return std::pair(result.by_cause, result.commands);
  };
  const auto first = faults_of(5);
  EXPECT_EQ(first, faults_of(5));
  EXPECT_NE(first, faults_of(6));
}

}  // namespace
}  // namespace hystcan::support::repeatable_storm_test
