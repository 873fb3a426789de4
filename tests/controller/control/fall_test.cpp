// The states of a fault and their transitions. tests/safety/fault_ramp_test.cpp tests every input that ends
// the ramp.
#include "controller/control/fall.h"

#include <gtest/gtest.h>

#include "tests/controller/control/healthy.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::fall_test {
namespace {

using State = Fall::State;

class FallStates : public testing::Test {
 protected:
  FallStates() { output_check_.restart(drive_); }
  State trip(Cause cause, bool is_driven = true) {
    fall_.trip({cause, 1.0}, is_driven, 10.0 / exact_cycle_s);
    return fall_.state();
  }
  State step() {
    command_ = fall_.step(config_, input_, output_check_, drive_);
    return fall_.state();
  }

  AxisConfig config_ = support::piezo_axis();
  AxisInput input_ = sample(5.0);
  OutputCheck output_check_ = output_check_of(config_);
  double drive_ = 15.0;
  Fall fall_;
  AxisCommand command_;
};

TEST_F(FallStates, ChangeFromNoneToSafeIfTheDriveIsUncontrollable) {
  EXPECT_EQ(trip(Cause::bus_off), State::safe);
}

TEST_F(FallStates, ChangeFromNoneToSafeIfTheAxisIsNotDriven) {
  EXPECT_EQ(trip(Cause::following_error, false), State::safe);
}

TEST_F(FallStates, ChangeFromNoneOverRampingToSafeAtTheSafeDrive) {
  EXPECT_EQ(trip(Cause::following_error), State::ramping);
  EXPECT_EQ(step(), State::ramping);
  EXPECT_EQ(drive_, 5.0);
  EXPECT_EQ(step(), State::ramping);
  EXPECT_TRUE(command_.enable);
  EXPECT_EQ(step(), State::safe);
  EXPECT_FALSE(command_.enable);
}

TEST_F(FallStates, ChangeFromRampingToSafeByASecondCauseKeepsTheFirst) {
  trip(Cause::following_error);
  EXPECT_EQ(trip(Cause::bus_off), State::safe);
  EXPECT_EQ(fall_.fault().cause, Cause::following_error);
}

TEST_F(FallStates, ChangeFromRampingToSafeIfTheAmplifierIsNoLongerEnabled) {
  trip(Cause::following_error);
  input_.health.amplifier_enabled = false;
  EXPECT_EQ(step(), State::safe);
}

TEST_F(FallStates, StaySafeAfterFurtherTrips) {
  trip(Cause::bus_off);
  EXPECT_EQ(trip(Cause::following_error), State::safe);
}

}  // namespace
}  // namespace hystcan::controller::fall_test
