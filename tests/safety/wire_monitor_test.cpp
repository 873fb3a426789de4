// The monitor detects hand-made frames, each with one error.
#include "tests/support/wire_monitor.h"

#include <gtest/gtest.h>

#include "config/schema/config.h"
#include "controller/control/axis.h"
#include "tests/support/shows.h"

namespace hystcan::support::wire_monitor_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

const config::Config& shipped() {
  static const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  return config;
}

/// The slew limit is 20 V per cycle, the range 0..100 V, the safe value 0 V; a cycle is 1 ms.
class WireMonitorTest : public testing::Test {
 protected:
  void sync() {
    now += milliseconds(1);
    counter = can::next_sync_counter(counter);
    monitor.receive(can::sync_frame(counter), now);
  }
  void cycle(double setpoint, bool enable) {
    sync();
    monitor.receive(*command({.setpoint = setpoint, .enable = enable, .sync_counter = counter}),
                    now + microseconds(300));
  }
  void status(double output, can::AmpState state) {
    monitor.receive(*amplifier({.output = output, .state = state}), now + microseconds(600));
  }
  void report(controller::AxisState state) {
    monitor.receive(*controller({.state = static_cast<std::uint8_t>(state)}), now + microseconds(600));
  }
  /// Raises the drive to 50 V in steps of 10 V; the amplifier follows.
  void drive_up() {
    for (int i = 0; i <= 5; ++i) {
      cycle(10.0 * i, true);
      status(10.0 * i, can::AmpState::enabled);
    }
  }
  void expect_only(Violation violation) {
    EXPECT_EQ(monitor.count(violation), 1u) << to_string(violation);
    EXPECT_EQ(monitor.violations(), 1u) << (monitor.found().empty() ? "" : monitor.found().back());
  }

  const can::Database& database = shipped().database;
  WireMonitor monitor{{.wire = shipped().axes[0].wire,
                       .gate = shipped().axes[0].control.gate,
                       .output_min = -20.0,
                       .output_max = 120.0,
                       .settle = milliseconds(3),
                       .off_within = milliseconds(21),
                       .grace = microseconds(1300),
                       .jitter = microseconds(100)},
                      database};
  can::Encoder<can::AmpCommand> command{*database.find("XAmpCommand")};
  can::Encoder<can::AmpStatus> amplifier{*database.find("XAmpStatus")};
  can::Encoder<can::ControllerStatus> controller{*database.find("XControllerStatus")};
  can::Time now{};
  std::uint8_t counter = 0;
};

TEST_F(WireMonitorTest, FindsNoViolationInACorrectRun) {
  cycle(0.0, false);
  status(0.0, can::AmpState::ready);
  drive_up();
  cycle(0.0, false);
  status(49.0, can::AmpState::ready);
  report(controller::AxisState::faulted);
  for (int i = 0; i < 5; ++i) cycle(0.0, false);
  status(0.0005, can::AmpState::ready);
  monitor.report_clear();
  report(controller::AxisState::waiting);
  drive_up();
  EXPECT_EQ(monitor.violations(), 0u);
  EXPECT_EQ(monitor.commands(), 19u);
  EXPECT_EQ(monitor.statuses(), 15u);
}

TEST_F(WireMonitorTest, CatchesADriveOutOfRange) {
  shows("S-066");
  for (int i = 0; i <= 10; ++i) cycle(10.0 * i, true);
  cycle(100.00001, true);
  expect_only(Violation::drive_out_of_range);
}

TEST_F(WireMonitorTest, CatchesAStepAboveTheSlewLimit) {
  shows("S-066");
  drive_up();
  cycle(72.0, true);
  EXPECT_EQ(monitor.violations(), 0u) << "20 V in a cycle and 2 V in the jitter";
  cycle(94.1, true);
  expect_only(Violation::drive_too_fast);
}

TEST_F(WireMonitorTest, AllowsAFullStepForEachCycleWithoutACommand) {
  drive_up();
  sync();
  cycle(90.0, true);
  EXPECT_EQ(monitor.violations(), 0u);
}

TEST_F(WireMonitorTest, CatchesAStartAwayFromTheAmplifierOutput) {
  cycle(0.0, false);
  status(0.0, can::AmpState::ready);
  for (int i = 0; i < 5; ++i) cycle(0.0, false);
  cycle(50.0, true);
  expect_only(Violation::start_not_at_output);
}

TEST_F(WireMonitorTest, CatchesADriveOtherThanTheSafeValueWhileNotEnabled) {
  shows("S-066");
  cycle(0.00001, false);
  expect_only(Violation::unsafe_when_not_enabled);
}

TEST_F(WireMonitorTest, CatchesAnEnabledCommandAfterAFault) {
  shows("S-066");
  drive_up();
  report(controller::AxisState::faulted);
  cycle(50.0, true);
  EXPECT_EQ(monitor.violations(), 0u) << "it is already on its way";
  cycle(50.0, true);
  expect_only(Violation::enabled_while_faulted);
}

TEST_F(WireMonitorTest, CatchesAnEnabledCommandAfterAReportedFault) {
  drive_up();
  monitor.report_fault(now);
  cycle(50.0, true);
  cycle(50.0, true);
  expect_only(Violation::enabled_while_faulted);
}

TEST_F(WireMonitorTest, CatchesAnOutputOutOfTheAmplifiersRange) {
  drive_up();
  status(120.1, can::AmpState::enabled);
  expect_only(Violation::output_out_of_range);
}

TEST_F(WireMonitorTest, CatchesAnOutputThatDoesNotFallToTheSafeValue) {
  shows("S-066");
  drive_up();
  cycle(0.0, false);
  status(50.0, can::AmpState::ready);
  for (int i = 0; i < 4; ++i) cycle(0.0, false);
  status(0.002, can::AmpState::ready);
  expect_only(Violation::output_not_safe);
}

TEST_F(WireMonitorTest, CatchesAnAmplifierThatStaysEnabled) {
  drive_up();
  for (int i = 0; i < 20; ++i) cycle(0.0, false);
  status(0.0, can::AmpState::enabled);
  EXPECT_EQ(monitor.violations(), 0u) << "its watchdog still has time";
  cycle(0.0, false);
  status(0.0, can::AmpState::enabled);
  expect_only(Violation::not_switched_off);
}

TEST_F(WireMonitorTest, IgnoresADamagedCommand) {
  drive_up();
  sync();
  can::Frame damaged = *command({.setpoint = 1000.0, .enable = true, .sync_counter = counter});
  damaged.data[7] ^= 1U;
  monitor.receive(damaged, now);
  EXPECT_EQ(monitor.violations(), 0u);
  EXPECT_EQ(monitor.commands(), 6u);
}

}  // namespace
}  // namespace hystcan::support::wire_monitor_test
