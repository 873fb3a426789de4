// The loop with a laboratory's own frames: 16-bit big-endian millivolts, 24-bit position, 29-bit identifiers.
#include <gtest/gtest.h>

#include <functional>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"

namespace hystcan::lab_frames_test {
namespace {

using controller::AxisState;
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

TEST(LabFrames, AreSentAsCanFdIfVFrameFormatRequiresIt) {
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

}  // namespace
}  // namespace hystcan::lab_frames_test
