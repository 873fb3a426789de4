// A short storm of random faults; the long one is tests/bench/bench_storm.cpp, `ctest -C long`
// (docs/safety.md).
#include "tests/support/storm.h"
#include "tests/support/shows.h"

#include <gtest/gtest.h>

namespace hystcan::support::storm_test {
namespace {

TEST(Storm, CausesNoUnsafeFrameAndNoStuckAxis) {
  shows("S-065, S-067, S-068, S-069");
  const StormResult result = run_storm({.seed = 1, .virtual_s = 600.0, .warm_up_s = 120.0});
  print(result);
  EXPECT_TRUE(result.has_passed());
  EXPECT_GT(result.faults, 100u);
  EXPECT_LE(result.in_a_step.worst_ms, safe_in_a_step_ms) << result.in_a_step.episode;
  EXPECT_LE(result.between_steps.worst_ms, safe_between_steps_ms) << result.between_steps.episode;
  EXPECT_LE(result.resident_at_end_kB, result.resident_after_warm_up_kB + 256)
      << "64 pages, which the heap may touch for the first time late";
}

}  // namespace
}  // namespace hystcan::support::storm_test
