// The check of the amplifier's output: the last matching and the first differing output, the time for which a
// drive counts, and the reset at a start. tests/safety/output_check_test.cpp tests the check in an axis.
#include <gtest/gtest.h>

#include "controller/control/output_check.h"

namespace hystcan::controller::output_check_test {
namespace {

constexpr double range = 100.0, cycle_s = 1.0 / 1024.0, unlimited = 1e6;

AxisInput status(double output, double age_s = 0.0, double of_cycle_s = cycle_s) {
  AxisInput input;
  input.dt_s = input.cycle_s = of_cycle_s;
  input.health.output_reported = true;
  input.health.amplifier_output = output;
  input.health.status_age_s = age_s;
  return input;
}

/// Returns true if this output agrees in the cycle after a drive of 20 with an old status.
bool agrees(double output, double drive, double slew_per_s, double lag_s = 0.0, double age_s = 0.0) {
  OutputCheck check(range, lag_s);
  check.restart(20.0);
  check.step(20.0, 0.0, status(20.0, 0.04));
  check.step(drive, slew_per_s, status(output, age_s));
  return check.differs_for_s() == 0.0;
}

TEST(OutputCheck, AllowsFivePercentOfTheRangeAtRest) {
  EXPECT_TRUE(agrees(25.0, 20.0, 0.0));
  EXPECT_TRUE(agrees(15.0, 20.0, 0.0));
  EXPECT_FALSE(agrees(25.001, 20.0, 0.0));
  EXPECT_FALSE(agrees(14.999, 20.0, 0.0));
}

TEST(OutputCheck, AllowsFivePercentBeyondTheRecentDrives) {
  EXPECT_TRUE(agrees(85.0, 80.0, unlimited));
  EXPECT_TRUE(agrees(15.0, 80.0, unlimited));
  EXPECT_FALSE(agrees(85.001, 80.0, unlimited));
  EXPECT_FALSE(agrees(14.999, 80.0, unlimited));
}

// 5 + 1024 (4 / 1024) = 9 of the range.
TEST(OutputCheck, AllowsFourCyclesOfTheSlew) {
  EXPECT_TRUE(agrees(71.0, 80.0, 1024.0));
  EXPECT_FALSE(agrees(70.999, 80.0, 1024.0));
}

TEST(OutputCheck, AllowsFiveLagsAndTheStatusAgeOfTheSlew) {
  const double slew_per_s = 15.0 / (4.0 * cycle_s + 5.0 * 0.002);
  EXPECT_TRUE(agrees(60.001, 80.0, slew_per_s, 0.002));
  EXPECT_FALSE(agrees(59.999, 80.0, slew_per_s, 0.002));
  const double aged_per_s = 15.0 / (4.0 * cycle_s + 0.01);
  EXPECT_TRUE(agrees(60.001, 80.0, aged_per_s, 0.0, 0.01));
  EXPECT_FALSE(agrees(59.999, 80.0, aged_per_s, 0.0, 0.01));
}

/// Returns the number of cycles for which the previous drive counts after a step.
int cycles_counted(double lag_s, double of_cycle_s) {
  OutputCheck check(range, lag_s);
  check.restart(20.0);
  for (int cycle = 1; cycle < 1000; ++cycle) {
    check.step(80.0, unlimited, status(20.0, 0.0, of_cycle_s));
    if (check.differs_for_s() > 0.0) return cycle;
  }
  return 0;
}

TEST(OutputCheck, RemembersTheDrivesOfThreeSpans) {
  EXPECT_EQ(cycles_counted(0.0, cycle_s), 3 * 52) << "52 cycles are the first that are not less than 50 ms";
  EXPECT_EQ(cycles_counted(0.02, cycle_s), 3 * 103);
  EXPECT_EQ(cycles_counted(0.0, 1.0 / 64.0), 3 * 5);
}

TEST(OutputCheck, IgnoresAStatusOlderThanASpan) {
  for (const double age_s : {0.05, 0.050001}) {
    OutputCheck check(range, 0.0);
    check.restart(80.0);
    check.step(80.0, 0.0, status(20.0, 0.06));
    check.step(80.0, 0.0, status(20.0, age_s));
    EXPECT_EQ(check.differs_for_s() > 0.0, age_s == 0.05);
  }
}

TEST(OutputCheck, KeepsAVerdictForASpanWhileOutputsAreReported) {
  OutputCheck differs(range, 0.0);
  differs.restart(80.0);
  differs.step(80.0, 0.0, status(20.0));
  differs.step(80.0, 0.0, status(20.0, 0.05));
  ASSERT_EQ(differs.differs_for_s(), 2.0 * cycle_s);
  OutputCheck unreported = differs;
  AxisInput without = status(20.0, 0.05);
  without.health.output_reported = false;
  unreported.step(80.0, 0.0, without);
  EXPECT_EQ(unreported.differs_for_s(), 0.0);
  differs.step(80.0, 0.0, status(20.0, 0.051));
  EXPECT_EQ(differs.differs_for_s(), 0.0);
}

// The age is counted in cycles and rounded.
TEST(OutputCheck, AcceptsAStatusAsNewIfAgedByUnderHalfACycle) {
  for (const double aged_cycles : {0.499, 0.5}) {
    OutputCheck check(range, 0.0);
    check.restart(80.0);
    check.step(80.0, 0.0, status(20.0, aged_cycles * cycle_s));
    EXPECT_EQ(check.differs_for_s() > 0.0, aged_cycles < 0.5);
  }
}

TEST(OutputCheck, ClearsDrivesVerdictAndTimeAtARestart) {
  OutputCheck check(range, 0.0);
  check.restart(80.0);
  check.step(80.0, 0.0, status(20.0));
  check.step(80.0, 0.0, status(20.0, 0.04));
  ASSERT_EQ(check.differs_for_s(), 2.0 * cycle_s);
  check.restart(20.0);
  EXPECT_EQ(check.differs_for_s(), 0.0);
  check.step(20.0, unlimited, status(80.0, 0.03));
  EXPECT_EQ(check.differs_for_s(), 0.0) << "a status from before the restart";
  check.step(20.0, unlimited, status(80.0));
  EXPECT_EQ(check.differs_for_s(), cycle_s) << "80 was a drive of before";
}

}  // namespace
}  // namespace hystcan::controller::output_check_test
