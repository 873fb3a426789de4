// An amplifier whose relay or soft start delays the state enabled. The controller waits for it: the stage
// moves by the ramp of the start-up and never in a step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>

#include "tests/support/fault_rig.h"
#include "tests/support/shows.h"

namespace hystcan::support::slow_enable_test {
namespace {

using controller::AxisState;
using controller::Cause;
using std::chrono::milliseconds;

struct Way {
  int delay_ms;
  int soft_start_ms;

  friend void PrintTo(const Way& way, std::ostream* out) {
    *out << way.delay_ms << " ms and a soft start of " << way.soft_start_ms << " ms";
  }
};

config::Config with(const Way& way) {
  config::Config config = one_axis();
  config.axes[0].twin.enable_delay = milliseconds(way.delay_ms);
  config.axes[0].twin.soft_start = milliseconds(way.soft_start_ms);
  return config;
}

class SlowEnable : public testing::TestWithParam<Way> {};

TEST_P(SlowEnable, MakesNoStepAndWipesTheMemory) {
  shows("S-055, S-121");
  FaultRig rig(with(GetParam()));
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

/// While the relay is open there is nothing to ramp down.
TEST(StopBeforeTheRelayCloses, SwitchesOffAtOnce) {
  FaultRig rig(with({300, 0}));
  rig.start();
  ASSERT_TRUE(rig.reaches(AxisState::initialising, std::chrono::seconds(1)));
  rig.run_for(milliseconds(50));
  rig.controller().request_stop();
  rig.run_for(milliseconds(2));
  EXPECT_EQ(rig.axis().state(), AxisState::offline);
  EXPECT_TRUE(rig.monitor().commands_are_safe());
  rig.run_for(milliseconds(400));
  EXPECT_EQ(rig.stage().amplifier.state(), can::AmpState::ready);
  EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
}

INSTANTIATE_TEST_SUITE_P(, SlowEnable,
                         testing::Values(Way{0, 0}, Way{1, 0}, Way{20, 0}, Way{100, 0}, Way{300, 0},
                                         Way{480, 0}, Way{0, 20}, Way{0, 400}, Way{100, 200}),
                         [](const auto& test) {
                           return "After" + std::to_string(test.param.delay_ms) + "MsAndASoftStartOf" +
                                  std::to_string(test.param.soft_start_ms);
                         });

/// The amplifier does not report whether it is enabled.
TEST(SilentEnable, IsAssumedAfterTheConfiguredDelay) {
  shows("S-056");
  config::Config config = with({.delay_ms = 100, .soft_start_ms = 0});
  config.axes[0].control.enable_delay = milliseconds(150);
  FaultRig rig(config);
  rig.start();
  ASSERT_TRUE(rig.reaches(AxisState::initialising, std::chrono::seconds(1)));
  rig.run_for(milliseconds(149));
  EXPECT_EQ(rig.axis().report().arming_blocks, controller::ArmingBlock::enabled);
  EXPECT_EQ(rig.axis().report().drive, 0.0);
  rig.run_for(milliseconds(20));
  EXPECT_GT(rig.axis().report().drive, 0.0);
}

TEST(TooSlowEnable, IsToleratedIfTheDelayIsConfigured) {
  shows("S-122");
  config::Config config = with({.delay_ms = 600, .soft_start_ms = 200});
  config.axes[0].control.enable_delay = milliseconds(500);
  FaultRig rig(config);
  rig.start();
  EXPECT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
}

TEST(TooSlowEnable, IsAFaultBeyondHalfASecond) {
  shows("S-031, S-122");
  FaultRig rig(with({.delay_ms = 600, .soft_start_ms = 0}));
  rig.start();
  ASSERT_TRUE(rig.reaches(AxisState::faulted, std::chrono::seconds(3)));
  EXPECT_EQ(rig.axis().fault().cause, Cause::amplifier_not_enabled);
  rig.run_for(milliseconds(200));
  rig.stage().plant.advance_to(rig.clock().now());
  EXPECT_NEAR(rig.stage().plant.drive(), 0.0, 1e-3);
}

/// The relay opens for a cycle at any time after the amplifier reported that it is enabled. The amplifier
/// accepts the next Enable, so a ramp that continued would cause a step of the stage.
class BouncingRelay : public testing::TestWithParam<controller::MemorySource> {};

TEST_P(BouncingRelay, FaultsWithinTwoCyclesInEveryPhaseOfTheStart) {
  shows("S-031, S-122");
  for (int phase_ms = 1; phase_ms < 500; phase_ms += 25) {
    SCOPED_TRACE(phase_ms);
    config::Config config = with({.delay_ms = 20, .soft_start_ms = 0});
    config.axes[0].control.start_up = GetParam();
    FaultRig rig(config);
    rig.start();
    const auto is_enabled = [&] { return rig.stage().amplifier.state() == can::AmpState::enabled; };
    for (int i = 0; i < 2000 && !is_enabled(); ++i) rig.run_for(milliseconds(1));
    rig.run_for(milliseconds(phase_ms + 1));
    ASSERT_NE(rig.axis().state(), AxisState::faulted) << to_string(rig.axis().fault().cause);
    const can::Time opened = rig.clock().now();
    rig.begin(Trouble::enable_lost);
    rig.run_for(milliseconds(1));
    rig.end(Trouble::enable_lost);
    ASSERT_TRUE(rig.reaches(AxisState::faulted, milliseconds(5)));
    EXPECT_EQ(rig.axis().fault().cause, Cause::amplifier_not_enabled);
    EXPECT_LE(rig.decided_at() - opened, milliseconds(2));
    rig.run_for(milliseconds(50));
    EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
  }
}

INSTANTIATE_TEST_SUITE_P(, BouncingRelay,
                         testing::Values(controller::MemorySource::wipe, controller::MemorySource::assume),
                         [](const auto& test) {
                           return test.param == controller::MemorySource::wipe ? "Wipe" : "Assume";
                         });

}  // namespace
}  // namespace hystcan::support::slow_enable_test
