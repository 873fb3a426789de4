// The loop with a laboratory's own frames: 16-bit big-endian millivolts, 24-bit position, 29-bit identifiers.
#include <gtest/gtest.h>

#include <functional>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"

namespace hystcan::lab_frames_test {
namespace {

using controller::AxisState;
using std::chrono::milliseconds;
using support::ignore;
using support::shipped;

/// Changes the frames of controller and twin in the same way.
void change_frames(rehearsal::Setup& setup, const std::function<void(can::AxisFrames&)>& change) {
  change(*setup.controller.axes[0].wire.frames);
  change(*setup.twin.axes[0].wire.frames);
}

/// RMS error over the triangle, in % of stroke.
double triangle_percent(const rehearsal::Setup& setup) {
  const rehearsal::Outcome outcome = rehearsal::run_once(setup, 0.1, ignore);
  EXPECT_EQ(outcome.axes[0].state, AxisState::tracking) << to_string(outcome.axes[0].fault.cause);
  EXPECT_EQ(outcome.counters.late_samples, 0u);
  return support::triangle_percent(outcome);
}

// One step of the setpoint is 2 mV, or 0.6 nm of the stage. Rounding adds 0.17 nm RMS, 1/350 of the error.
TEST(LabFrames, TrackAsWellAsTheStandardFrames) {
  rehearsal::Setup standard = shipped("piezo.toml");
  standard.controller.axes.resize(1);
  standard.twin.axes.resize(1);
  const double expected = triangle_percent(standard);
  const double measured = triangle_percent(shipped("lab_amplifier.toml"));
  RecordProperty("standard_percent", std::to_string(expected));
  RecordProperty("lab_percent", std::to_string(measured));
  EXPECT_LE(measured, 0.25);
  EXPECT_NEAR(measured, expected, 0.01 * expected);
}

TEST(LabFrames, TrackWithSetpointAndPositionAsTheirOnlySignals) {
  rehearsal::Setup setup = shipped("lab_amplifier.toml");
  change_frames(setup, [](can::AxisFrames& frames) {
    frames.command.signals = {{"setpoint", "Volt"}};
    frames.command.integrity = can::Integrity::none;
    frames.status.reset();
    frames.sample.signals = {{"position", "Pos"}};
  });
  EXPECT_LE(triangle_percent(setup), 0.25);
}

TEST(LabFrames, AreSentAsCanFdWhenTheirMessageIsLongerThanEightBytes) {
  rehearsal::Setup setup = shipped("lab_amplifier.toml");
  for (can::Message& message : setup.database.messages)
    if (message.name == "AmpSet" || message.name == "SensPos") message.length = 18;
  rehearsal::Rehearsal rehearsal(setup, ignore);
  unsigned fd_frames = 0;
  const auto listener = rehearsal.attach()({});
  listener->on_frame([&](const can::Frame& frame, can::Time) {
    if (frame.kind == can::FrameKind::fd && frame.length == 20 && frame.extended) ++fd_frames;
  });
  rehearsal.start();
  rehearsal.run_for(std::chrono::seconds(2));
  EXPECT_EQ(rehearsal.controller().axis(0).state(), AxisState::tracking);
  EXPECT_GT(fd_frames, 3000u) << "a command and a sample in each cycle after the start";
}

/// AmpSet and SensPos of 18 bytes are 20 on the wire: 266 bits each at 1 Mbit/s, or 32 and 234 / 5.
TEST(LabFrames, TakeLessTimeOnTheBusWithBitRateSwitch) {
  double load[2] = {};
  for (const bool switches : {false, true}) {
    rehearsal::Setup setup = shipped("lab_amplifier.toml");
    setup.rates.data_bit_per_s = 5'000'000;
    for (can::Message& message : setup.database.messages) {
      if (message.name != "AmpSet" && message.name != "SensPos") continue;
      message.length = 18;
      message.bit_rate_switch = switches;
    }
    rehearsal::Rehearsal rehearsal(setup, ignore);
    rehearsal.start();
    rehearsal.run_for(std::chrono::seconds(1));
    EXPECT_EQ(rehearsal.controller().axis(0).state(), AxisState::tracking);
    load[switches ? 1 : 0] = rehearsal.bus().load();
  }
  EXPECT_LT(load[1], 0.45 * load[0]);
}

TEST(LabFrames, AreSentAsCanFdWhenVFrameFormatSaysSoHoweverShort) {
  rehearsal::Setup setup = shipped("lab_amplifier.toml");
  for (can::Message& message : setup.database.messages) message.fd = message.bit_rate_switch = true;
  rehearsal::Rehearsal rehearsal(setup, ignore);
  bool all_switch = true;
  const auto listener = rehearsal.attach()({});
  listener->on_frame([&](const can::Frame& frame, can::Time) {
    const bool is_ours = frame.extended;
    all_switch &= !is_ours || (frame.kind == can::FrameKind::fd && frame.fd_flags == can::fd_bit_rate_switch);
  });
  rehearsal.start();
  rehearsal.run_for(std::chrono::seconds(1));
  EXPECT_EQ(rehearsal.controller().axis(0).state(), AxisState::tracking);
  EXPECT_TRUE(all_switch);
}

TEST(LabFrames, FaultTheAxisWhenTheAmplifierReportsAFaultInThem) {
  rehearsal::Setup setup = shipped("lab_amplifier.toml");
  rehearsal::Rehearsal rehearsal(setup, ignore);
  rehearsal.start();
  rehearsal.run_for(std::chrono::seconds(1));
  ASSERT_EQ(rehearsal.controller().axis(0).state(), AxisState::tracking);
  const auto foreign_node = rehearsal.attach()({});
  for (int i = 0; i < 2; ++i) {  // at least one of the two counters differs from the last one received
    can::Frame frame{.id = 0x18EE1001, .extended = true, .length = 4, .data = {0x27, 0x10, 65}};
    frame.data[3] = static_cast<std::uint8_t>(200 + i);
    foreign_node->send(frame);
  }
  rehearsal.run_for(milliseconds(3));
  EXPECT_EQ(rehearsal.controller().axis(0).fault().cause, controller::Cause::amplifier_fault);
}

TEST(LabFrames, AreRejectedAndCountedWhenSentWithAStandardIdentifier) {
  rehearsal::Setup setup = shipped("lab_amplifier.toml");
  for (can::Message& message : setup.database.messages)
    if (message.name == "SensPos") message.id = 0x182;
  rehearsal::Rehearsal rehearsal(setup, ignore);
  rehearsal.start();
  rehearsal.run_for(std::chrono::seconds(1));
  const auto foreign_node = rehearsal.attach()({});
  foreign_node->send({.id = 0x182, .extended = false, .length = 4, .data = {}});
  rehearsal.run_for(milliseconds(3));
  EXPECT_EQ(
      rehearsal.controller().wired_axis(0).sensor.samples().checker().rejected(can::Rejection::extended_id),
      1u);
  EXPECT_EQ(rehearsal.controller().axis(0).state(), AxisState::tracking);
}

TEST(LabFrames, AllocateNothingWhileTracking) {
  EXPECT_EQ(support::allocations_while_tracking(shipped("lab_amplifier.toml")), 0U);
}

}  // namespace
}  // namespace hystcan::lab_frames_test
