#include "controller/command_frame.h"

#include <gtest/gtest.h>

#include "can/dbc/reader.h"
#include "tests/support/outbox.h"
#include "tests/support/shows.h"

namespace hystcan::controller::command_frame_test {
namespace {

can::Layout<can::AmpCommand> layout(const std::string& axis) {
  static const can::Database database = can::parse_dbc(R"(VERSION ""
BU_: Controller
BO_ 528 Commands: 12 Controller
 SG_ X : 0|16@1+ (0.01,0) [0|150] "V" Vector__XXX
 SG_ Y : 16|16@1+ (0.01,0) [0|150] "V" Vector__XXX
 SG_ EnX : 32|1@1+ (1,0) [0|1] "" Vector__XXX
 SG_ EnY : 33|1@1+ (1,0) [0|1] "" Vector__XXX
 SG_ SyncCounter : 40|8@1+ (1,0) [0|240] "" Vector__XXX
 SG_ Counter : 48|8@1+ (1,0) [0|255] "" Vector__XXX
 SG_ Crc : 56|16@1+ (1,0) [0|65535] "" Vector__XXX
)",
                                                       "commands.dbc");
  const can::MessageMap map{
      .message = "Commands",
      .signals = {{"setpoint", axis}, {"enable", "En" + axis}, {"sync_counter", "SyncCounter"}},
      .polynomial = can::Crc::crc16};
  return {can::find_message(database, map), map, "V"};
}

can::AmpCommand decoded(const std::string& axis, const can::Frame& frame) {
  return layout(axis).decode(frame);
}

AxisCommand driven(double drive) { return {.drive = drive, .enable = true}; }

class OneAxis : public testing::Test {
 protected:
  OneAxis() {
    frame.add(layout("X"), 0, 1.0);
    frame.begin_to_count_echoes();
  }
  bool send(double drive) { return send(driven(drive)); }
  bool send(const std::optional<AxisCommand>& command) {
    sync = can::next_sync_counter(sync);
    frame.put(0, command, sync);
    return frame.send(queue);
  }
  void echo() { frame.on_echo(queue.frames.back(), sync, queue); }
  void echo_sync(std::uint8_t counter) { frame.on_echo(can::sync_frame(counter), sync, queue); }
  double last() const { return decoded("X", queue.frames.back()).setpoint; }

  support::Outbox queue;  ///< frames accepted by the interface; the test sends the echoes
  CommandFrame frame{layout("X")};
  std::uint8_t sync = 0;
};
using CommandFrameOfOneAxis = OneAxis;

TEST_F(CommandFrameOfOneAxis, WaitsWhileThePreviousOneIsQueued) {
  send(10.0);
  send(20.0);
  EXPECT_EQ(queue.frames.size(), 1u);
  echo();
  ASSERT_EQ(queue.frames.size(), 2u);
  EXPECT_NEAR(last(), 20.0, 1e-9);
}

TEST_F(CommandFrameOfOneAxis, ContainsTheCommandAfterPut) {
  EXPECT_TRUE(frame.has(0)) << "before the first cycle there is none to wait for";
  frame.begin_cycle();
  EXPECT_FALSE(frame.has(0));
  send(10.0);
  EXPECT_TRUE(frame.has(0));
}

TEST_F(CommandFrameOfOneAxis, IsReplacedByANewerOneAndCounted) {
  shows("S-047");
  EXPECT_FALSE(send(10.0));
  EXPECT_FALSE(send(20.0));
  EXPECT_TRUE(send(30.0));
  EXPECT_TRUE(send(40.0));
  echo();
  ASSERT_EQ(queue.frames.size(), 2u);
  EXPECT_NEAR(last(), 40.0, 1e-9);
}

TEST_F(CommandFrameOfOneAxis, LeavesNoGapInTheCounterWhenItIsReplaced) {
  for (const double drive : {10.0, 20.0, 30.0}) send(drive);
  echo();
  can::E2eChecker checker = layout("X").checker();
  EXPECT_FALSE(checker.check(queue.frames[0]));
  EXPECT_FALSE(checker.check(queue.frames[1]));
  EXPECT_EQ(queue.frames[1].data[6], queue.frames[0].data[6] + 1);
}

TEST_F(CommandFrameOfOneAxis, IsLateIfTwoAreQueued) {
  send(10.0);
  EXPECT_FALSE(frame.is_late());
  send(20.0);
  EXPECT_TRUE(frame.is_late());
  echo();
  EXPECT_FALSE(frame.is_late());
}

TEST_F(CommandFrameOfOneAxis, HasLeftIfALaterSyncHas) {
  send(10.0);
  echo_sync(sync);
  send(20.0);
  EXPECT_EQ(queue.frames.size(), 1u) << "the SYNC of its own cycle was before it";
  echo_sync(sync);
  EXPECT_EQ(queue.frames.size(), 2u) << "its own echo was lost";
}

TEST_F(CommandFrameOfOneAxis, HasNotLeftIfOnlyAnOlderSyncHas) {
  sync = 100;
  send(10.0);
  send(20.0);
  echo_sync(99);
  EXPECT_EQ(queue.frames.size(), 1u);
}

TEST_F(CommandFrameOfOneAxis, HasNotLeftIfOnlyASyncQueuedBeforeItHas) {
  send(10.0);
  send(20.0);
  sync = 3;  // is queued while the second one waits
  echo();
  ASSERT_EQ(queue.frames.size(), 2u);
  frame.put(0, driven(30.0), sync);
  frame.send(queue);
  echo_sync(3);
  EXPECT_EQ(queue.frames.size(), 2u);
  sync = 4;
  echo_sync(4);
  EXPECT_EQ(queue.frames.size(), 3u);
}

TEST_F(CommandFrameOfOneAxis, HasNotLeftIfOnlyAHeartbeatOrStatusHas) {
  send(10.0);
  send(20.0);
  frame.on_echo(can::heartbeat_frame(100, can::NmtState::operational), sync, queue);
  EXPECT_EQ(queue.frames.size(), 1u) << "its one byte is no SYNC counter";
  frame.on_echo({.id = 0x3A0, .length = 8}, sync, queue);
  EXPECT_EQ(queue.frames.size(), 1u);
}

TEST_F(CommandFrameOfOneAxis, HasLeftIfASyncAfterTheWrapOfTheCounterHas) {
  sync = can::sync_counter_max - 1;
  send(10.0);
  send(20.0);
  echo_sync(1);
  EXPECT_EQ(queue.frames.size(), 2u);
}

TEST_F(CommandFrameOfOneAxis, RecognisesItsEchoDespiteTheErrorStateFlag) {
  send(10.0);
  send(20.0);
  can::Frame echo = queue.frames.back();
  echo.fd_flags |= can::fd_error_state;
  frame.on_echo(echo, sync, queue);
  EXPECT_EQ(queue.frames.size(), 2u);
}

TEST_F(CommandFrameOfOneAxis, IsForeignEvenWithTheCounterOfOurLastOne) {
  send(10.0);
  can::Frame foreign = *layout("X").encode({.setpoint = 50.0, .enable = true});
  can::E2eProtector(layout("X").protection()).seal(foreign);
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(frame.is_sound(foreign)) << "its counter is 0, as that of ours";
  foreign.data[0] ^= 1;
  EXPECT_FALSE(frame.is_sound(foreign)) << "it is damaged";
}

TEST_F(CommandFrameOfOneAxis, IsNotSentDuringTheWatchdogVerification) {
  send(AxisCommand{.drive = 10.0, .enable = true, .withheld = true});
  EXPECT_TRUE(queue.frames.empty());
}

TEST_F(CommandFrameOfOneAxis, IsNotSentToAnAmplifierThatSleeps) {
  send(std::nullopt);
  EXPECT_TRUE(queue.frames.empty());
}

TEST_F(CommandFrameOfOneAxis, IsNotSentWithADriveThatDoesNotFit) {
  EXPECT_FALSE(frame.put(0, driven(1000.0), 1));
  frame.send(queue);
  EXPECT_TRUE(queue.frames.empty());
}

TEST_F(CommandFrameOfOneAxis, NeverWaitsIfTheBusReportsNoEcho) {
  CommandFrame without_echo(layout("X"));
  without_echo.add(layout("X"), 0, 1.0);
  for (std::uint8_t i = 1; i <= 5; ++i) {
    without_echo.put(0, AxisCommand{.drive = 1.0}, i);
    without_echo.send(queue);
  }
  EXPECT_EQ(queue.frames.size(), 5u);
  EXPECT_FALSE(without_echo.is_late());
}

TEST_F(CommandFrameOfOneAxis, DoesNotBlockTheNextIfTheInterfaceRefusedIt) {
  queue.takes = false;
  send(10.0);
  queue.takes = true;
  send(20.0);
  EXPECT_EQ(queue.frames.size(), 1u);
}

TEST_F(CommandFrameOfOneAxis, DoesNotWaitWhenItIsSafe) {
  for (const double drive : {10.0, 20.0}) send(drive);
  send(AxisCommand{.drive = 1.0});
  ASSERT_EQ(queue.frames.size(), 2u);
  EXPECT_NEAR(last(), 1.0, 1e-9);
  EXPECT_TRUE(frame.is_late());
  echo();
  EXPECT_EQ(queue.frames.size(), 2u) << "it has taken the place of the one that waited";
}

TEST_F(CommandFrameOfOneAxis, IsHeldBackWhileASafeOneIsQueued) {
  send(10.0);
  send(AxisCommand{.drive = 1.0});
  EXPECT_FALSE(send(AxisCommand{.drive = 1.0}));
  EXPECT_EQ(queue.frames.size(), 2u) << "it says nothing new";
  echo();
  send(AxisCommand{.drive = 1.0});
  EXPECT_EQ(queue.frames.size(), 3u);
}

TEST_F(CommandFrameOfOneAxis, CountsAsLostAfterAHundredSafeOnes) {
  send(AxisCommand{.drive = 1.0});
  for (int i = 0; i < 100; ++i) send(AxisCommand{.drive = 1.0});
  EXPECT_EQ(queue.frames.size(), 1u);
  send(AxisCommand{.drive = 1.0});
  EXPECT_EQ(queue.frames.size(), 2u);
  EXPECT_FALSE(frame.is_late());
}

TEST_F(CommandFrameOfOneAxis, IsHeldBackForAHundredCyclesAfterTheLastOneSent) {
  send(AxisCommand{.drive = 1.0});
  for (int i = 0; i < 60; ++i) send(AxisCommand{.drive = 1.0});
  echo();
  send(AxisCommand{.drive = 1.0});
  for (int i = 0; i < 100; ++i) send(AxisCommand{.drive = 1.0});
  EXPECT_EQ(queue.frames.size(), 2u);
}

TEST_F(CommandFrameOfOneAxis, HasLeftIfASyncUpToHalfARoundLaterHas) {
  constexpr std::uint8_t half = can::sync_counter_max / 2;
  send(10.0);
  send(20.0);
  echo_sync(static_cast<std::uint8_t>(1 + half));
  EXPECT_EQ(queue.frames.size(), 1u) << "or half a round earlier";
  echo_sync(half);
  EXPECT_EQ(queue.frames.size(), 2u);
}

TEST_F(CommandFrameOfOneAxis, IsDroppedWithTheBus) {
  send(10.0);
  send(20.0);
  frame.forget();
  EXPECT_FALSE(frame.is_late());
  EXPECT_FALSE(send(30.0)) << "it takes the place of none";
  ASSERT_EQ(queue.frames.size(), 2u);
  EXPECT_NEAR(last(), 30.0, 1e-9);
  echo();
  EXPECT_EQ(queue.frames.size(), 2u) << "what waited is forgotten too";
}

class TwoAxes : public OneAxis {
 protected:
  TwoAxes() { EXPECT_EQ(frame.add(layout("Y"), 1, 2.0), 1u); }
  void send(const std::optional<AxisCommand>& x, const std::optional<AxisCommand>& y) {
    ++sync;
    frame.put(0, x, sync);
    frame.put(1, y, sync);
    frame.send(queue);
  }
};
using CommandFrameOfTwoAxes = TwoAxes;

TEST_F(CommandFrameOfTwoAxes, HasBothSetpointsAndOneSyncCounter) {
  send(driven(10.0), driven(20.0));
  ASSERT_EQ(queue.frames.size(), 1u);
  EXPECT_FALSE(layout("Y").checker().check(queue.frames[0]));
  EXPECT_NEAR(decoded("X", queue.frames[0]).setpoint, 10.0, 1e-9);
  EXPECT_NEAR(decoded("Y", queue.frames[0]).setpoint, 20.0, 1e-9);
  EXPECT_EQ(decoded("Y", queue.frames[0]).sync_counter, sync);
}

TEST_F(CommandFrameOfTwoAxes, HasTheSafeDriveOfAnAxisThatSleeps) {
  send(driven(10.0), driven(20.0));
  echo();
  send(driven(11.0), std::nullopt);
  const can::AmpCommand y = decoded("Y", queue.frames.back());
  EXPECT_NEAR(y.setpoint, 2.0, 1e-9);
  EXPECT_FALSE(y.enable);
  EXPECT_NEAR(last(), 11.0, 1e-9);
}

TEST_F(CommandFrameOfTwoAxes, HasTheSafeDriveIfADriveDoesNotFit) {
  send(driven(1000.0), driven(20.0));
  ASSERT_EQ(queue.frames.size(), 1u);
  EXPECT_NEAR(last(), 1.0, 1e-9);
  EXPECT_FALSE(decoded("X", queue.frames[0]).enable);
  EXPECT_NEAR(decoded("Y", queue.frames[0]).setpoint, 20.0, 1e-9);
}

TEST_F(CommandFrameOfTwoAxes, IsNotSafeWhileOneAxisIsDriven) {
  send(AxisCommand{.drive = 1.0}, driven(20.0));
  send(AxisCommand{.drive = 1.0}, driven(21.0));
  echo();
  EXPECT_EQ(queue.frames.size(), 2u) << "the second one was not held back";
}

}  // namespace
}  // namespace hystcan::controller::command_frame_test
