// Conditions before the stage is driven: the amplifier's fault is cleared if a clear is requested, and a
// trial has shown that its watchdog works.
#include <gtest/gtest.h>

#include "tests/support/fault_rig.h"
#include "tests/support/lone_axis.h"
#include "tests/support/shows.h"

namespace hystcan::support::arming_test {
namespace {

using controller::ArmingBlock;
using controller::AxisState;
using controller::Cause;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Kind = controller::Request::Kind;

/// An interlock of the amplifier that is open from `begin` on.
struct Interlock {
  FaultRig rig{one_axis()};

  void open_while_tracking() {
    rig.start();
    ASSERT_TRUE(rig.tracks());
    rig.stage().amplifier.begin_internal_fault();
    ASSERT_TRUE(rig.reaches(AxisState::faulted, milliseconds(20)));
  }
  void clear_and_enable() {
    ASSERT_EQ(rig.ask(Kind::clear), "");
    ASSERT_EQ(rig.ask(Kind::enable), "");
  }
};

TEST(Clear, AttemptsForHalfASecondAndThenFaultsTheAxisAgain) {
  shows("S-057, S-139");
  Interlock interlock;
  interlock.open_while_tracking();
  interlock.clear_and_enable();
  interlock.rig.run_for(milliseconds(450));
  EXPECT_EQ(interlock.rig.axis().state(), AxisState::waiting);
  EXPECT_EQ(interlock.rig.axis().report().arming_blocks, ArmingBlock::clear);
  ASSERT_TRUE(interlock.rig.reaches(AxisState::faulted, milliseconds(100)));
  EXPECT_EQ(interlock.rig.axis().fault().cause, Cause::amplifier_fault);
}

TEST(Clear, DoesNotDriveAnAxisIfItsInterlockClosesLater) {
  shows("S-057");
  Interlock interlock;
  interlock.open_while_tracking();
  interlock.clear_and_enable();
  interlock.rig.run_for(seconds(1));
  interlock.rig.stage().amplifier.end_internal_fault();
  interlock.rig.run_for(seconds(2));
  EXPECT_EQ(interlock.rig.axis().state(), AxisState::faulted);
  EXPECT_EQ(interlock.rig.stage().amplifier.state(), can::AmpState::fault) << "no clear was asked for";
  interlock.clear_and_enable();
  EXPECT_TRUE(interlock.rig.tracks());
  EXPECT_EQ(interlock.rig.monitor().violations(), 0u);
}

/// The first fault is cleared within a few milliseconds, long before the half second ends.
TEST(Clear, IsNotStoredForALaterStart) {
  shows("S-058");
  Interlock interlock;
  FaultRig& rig = interlock.rig;
  interlock.open_while_tracking();
  rig.stage().amplifier.end_internal_fault();
  interlock.clear_and_enable();
  ASSERT_TRUE(rig.tracks());
  ASSERT_EQ(rig.ask(Kind::disable), "");
  ASSERT_TRUE(rig.reaches(AxisState::offline, seconds(3)));
  rig.stage().amplifier.begin_internal_fault();
  rig.stage().amplifier.end_internal_fault();
  rig.run_for(milliseconds(20));
  ASSERT_EQ(rig.ask(Kind::enable), "");
  ASSERT_TRUE(rig.reaches(AxisState::faulted, milliseconds(100)));
  EXPECT_EQ(rig.axis().fault().cause, Cause::amplifier_fault);
}

LoneAxis lone() {
  const config::Config config = one_axis();
  return {controller_config(config).axes[0], config.database};
}

/// Reports another state for less than a cycle while the amplifier is enabled, like a bouncing contact.
void bounce(LoneAxis& axis, can::AmpState state) {
  for (const can::AmpState said : {can::AmpState::enabled, state, can::AmpState::enabled})
    axis.hear_status({.state = said});
}

TEST(AmplifierFault, IsJudgedEvenIfItEndsWithinACycle) {
  LoneAxis axis = lone();
  bounce(axis, can::AmpState::fault);
  EXPECT_TRUE(axis.health().amplifier_fault);
  EXPECT_FALSE(axis.health().amplifier_fault) << "each event counts once";
}

TEST(AmplifierStatus, IsJudgedIfItIsBrieflyReadyWhileEnabled) {
  LoneAxis axis = lone();
  bounce(axis, can::AmpState::ready);
  EXPECT_FALSE(axis.health().amplifier_enabled);
  EXPECT_TRUE(axis.health().amplifier_enabled) << "each event counts once";
}

// If the first status counted as at rest, the axis would begin to drive while the output still moves.
TEST(AmplifierStatus, NeedsTwoToShowRestAlsoAfterABootUp) {
  LoneAxis axis = lone();
  for (int boot_up = 0; boot_up < 2; ++boot_up) {
    axis.hear_status({.state = can::AmpState::ready});
    EXPECT_TRUE(axis.health().amplifier_moves);
    axis.hear_status({.state = can::AmpState::ready});
    EXPECT_FALSE(axis.health().amplifier_moves);
    axis.wired.amplifier.on_heartbeat(can::heartbeat_frame(1, can::NmtState::boot_up), {});
  }
}

config::Config with_verification() {
  config::Config config = one_axis();
  config.axes[0].control.verify_watchdog = true;
  return config;
}

TEST(VerifiedWatchdog, TripsOnceBeforeTheFirstUse) {
  shows("S-059");
  FaultRig rig(with_verification());
  rig.start();
  ASSERT_TRUE(rig.reaches(AxisState::initialising, seconds(1)));
  ASSERT_TRUE(rig.reaches(AxisState::waiting, milliseconds(100))) << "tripped, and to be armed again";
  EXPECT_EQ(rig.stage().amplifier.fault(), can::amp_fault::command_timeout);
  ASSERT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
  EXPECT_EQ(rig.faults(), 0u);
  EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
}

TEST(VerifiedWatchdog, IsNotVerifiedAgainAfterAFault) {
  FaultRig rig(with_verification());
  rig.start();
  ASSERT_TRUE(rig.tracks());
  rig.begin(Trouble::sample_bad);
  ASSERT_TRUE(rig.reaches(AxisState::faulted, milliseconds(3)));
  rig.end(Trouble::sample_bad);
  ASSERT_EQ(rig.ask(Kind::clear), "");
  ASSERT_EQ(rig.ask(Kind::enable), "");
  ASSERT_TRUE(rig.reaches(AxisState::initialising, seconds(1)));
  for (int i = 0; i < 300 && rig.axis().state() != AxisState::tracking; ++i) {
    rig.run_for(milliseconds(1));
    ASSERT_NE(rig.stage().amplifier.state(), can::AmpState::fault);
  }
}

TEST(VerifiedWatchdog, FaultsTheAxisIfItDoesNotTrip) {
  shows("S-040");
  config::Config config = with_verification();
  config.axes[0].twin.command_timeout = seconds(60);
  FaultRig rig(config);
  rig.start();
  ASSERT_TRUE(rig.reaches(AxisState::faulted, seconds(3)));
  EXPECT_EQ(rig.axis().fault().cause, Cause::watchdog_failed);
  EXPECT_NEAR(rig.stage().plant.drive(), 0.0, 1e-3) << "nothing was driven";
}

}  // namespace
}  // namespace hystcan::support::arming_test
