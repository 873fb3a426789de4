// An amplifier whose relay or soft start takes its time from Enable to enabled. The controller waits for it: the
// stage moves by the ramp of the start-up and never in a step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/fault_rig.h"

namespace hystcan::support::slow_enable_test {
namespace {

using controller::AxisState;
using controller::Cause;
using std::chrono::milliseconds;

config::Config with_enable_delay(int delay_ms) {
  config::Config config = one_axis();
  config.axes[0].twin.enable_delay = milliseconds(delay_ms);
  return config;
}

class SlowEnable : public testing::TestWithParam<int> {};

TEST_P(SlowEnable, MakesNoStepAtTheStageAndLeavesTheMemoryWiped) {
  FaultRig rig(with_enable_delay(GetParam()));
  const auto drive = [&] {
    rig.stage().plant.advance_to(rig.clock().now());
    return rig.stage().plant.drive();
  };
  rig.start();
  double before = drive(), largest_step = 0.0, highest = before;
  for (int i = 0; i < 4000 && rig.axis().state() != AxisState::tracking; ++i) {
    rig.run_for(milliseconds(1));
    const double now = drive();
    largest_step = std::max(largest_step, std::abs(now - before));
    highest = std::max(highest, now);
    before = now;
  }
  ASSERT_EQ(rig.axis().state(), AxisState::tracking) << to_string(rig.axis().fault().cause);
  EXPECT_LE(largest_step, 1.05 * 1e-3 * rig.config().axes[0].control.wipe_slew_per_s);
  EXPECT_GE(highest, 99.5) << "the upper threshold is 100 V";
  EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
}

INSTANTIATE_TEST_SUITE_P(Milliseconds, SlowEnable, testing::Values(0, 1, 20, 100, 300, 480));

TEST(TooSlowEnable, BeyondHalfASecondIsAFault) {
  FaultRig rig(with_enable_delay(600));
  rig.start();
  ASSERT_TRUE(rig.reaches(AxisState::faulted, std::chrono::seconds(3)));
  EXPECT_EQ(rig.axis().fault().cause, Cause::amplifier_not_enabled);
  rig.run_for(milliseconds(200));
  rig.stage().plant.advance_to(rig.clock().now());
  EXPECT_NEAR(rig.stage().plant.drive(), 0.0, 1e-3);
}

}  // namespace
}  // namespace hystcan::support::slow_enable_test
