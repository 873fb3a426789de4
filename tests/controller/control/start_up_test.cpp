// The states of the start-up and their transitions. arming_test.cpp and axis_ramps_test.cpp test their effect
// on an axis.
#include "controller/control/start_up.h"

#include <gtest/gtest.h>

#include "tests/controller/control/healthy.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::start_up_test {
namespace {

using State = StartUp::State;

class StartUpStates : public testing::Test {
 protected:
  StartUpStates() {
    config_.wipe_slew_per_s = 100.0 / exact_cycle_s;  // a target is reached within a cycle
    config_.gate.slew_per_s = config_.wipe_slew_per_s;
    config_.wipe_dwell_s = 2.0 * exact_cycle_s;
    start_up_.visit({100.0, 0.0});
    start_up_.begin(false);
  }
  State step(const StartUp::Known& known = {.enabled = true}) {
    taken_ = start_up_.step(config_, input_, known, drive_, report_);
    return start_up_.state();
  }
  State arrive_at(State state) {
    for (int i = 0; i < 100 && start_up_.state() != state; ++i) step();
    return start_up_.state();
  }

  AxisConfig config_ = support::piezo_axis();
  AxisInput input_ = sample(5.0);
  StartUp start_up_{config_};
  StartUp::Step taken_;
  AxisReport report_;
  double drive_ = 0.0;
};

TEST_F(StartUpStates, StaysArmingWhileSomethingIsMissing) {
  input_.position_um.reset();
  EXPECT_EQ(step(), State::arming);
  EXPECT_FALSE(taken_.command.enable);
}

TEST_F(StartUpStates, ChangeFromArmingToFollowingAtTheOutput) {
  input_.health.amplifier_output = 30.0;
  EXPECT_EQ(step(), State::following);
  EXPECT_EQ(drive_, 30.0);
  EXPECT_FALSE(taken_.command.enable) << "the next command enables";
}

TEST_F(StartUpStates, StaysFollowingUntilTheAmplifierIsEnabled) {
  step();
  EXPECT_EQ(step({.enabled = false}), State::following);
  EXPECT_EQ(step({.enabled = true}), State::ramping);
}

TEST_F(StartUpStates, HoldsTheDriveOfARampForAnOutputThatDiffers) {
  step();
  EXPECT_EQ(step({.enabled = true, .output_differs = true}), State::ramping);
  EXPECT_EQ(drive_, 0.0);
  EXPECT_FALSE(taken_.moves);
}

TEST_F(StartUpStates, ChangeFromRampingToEndedAfterTheLastRest) {
  ASSERT_EQ(arrive_at(State::ramping), State::ramping);
  EXPECT_EQ(drive_, 100.0);
  EXPECT_EQ(step(), State::ramping) << "it has rested";
  EXPECT_EQ(step(), State::ramping);
  EXPECT_EQ(drive_, 0.0);
  EXPECT_EQ(step(), State::ended);
}

TEST_F(StartUpStates, SkipTheRampsIfTheMemoryIsKnown) {
  config_.start_up = MemorySource::assume;
  step({.memory = true});
  EXPECT_EQ(step(), State::ended);
}

TEST_F(StartUpStates, ChangeFromFollowingOverApproachingToWithholding) {
  config_.verify_watchdog = true;
  input_.health.amplifier_output = 100.0;
  config_.wipe_slew_per_s /= 2.0;
  step();
  EXPECT_EQ(step(), State::approaching);
  EXPECT_EQ(step(), State::withholding);
  EXPECT_EQ(step(), State::withholding);
  EXPECT_TRUE(taken_.command.withheld);
}

TEST_F(StartUpStates, ChangeFromWithholdingToArmingByTheTrip) {
  config_.verify_watchdog = true;
  ASSERT_EQ(arrive_at(State::withholding), State::withholding);
  input_.health.amplifier_fault = true;
  EXPECT_EQ(step(), State::arming);
  EXPECT_EQ(step(), State::arming);
  EXPECT_TRUE(taken_.command.clear_fault);
  input_.health.amplifier_fault = false;
  EXPECT_EQ(step(), State::following);
  EXPECT_EQ(step(), State::ramping);
}

TEST_F(StartUpStates, ChangeFromEveryStateToArmingByABegin) {
  for (const State state : {State::following, State::ramping, State::ended}) {
    ASSERT_EQ(arrive_at(state), state);
    start_up_.begin(false);
    EXPECT_EQ(start_up_.state(), State::arming);
  }
}

}  // namespace
}  // namespace hystcan::controller::start_up_test
