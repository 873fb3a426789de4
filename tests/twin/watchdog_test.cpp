// The output after commands have stopped, and the time at which a setpoint takes effect, observed at the bus
// and at the stage.
#include <gtest/gtest.h>

#include <cmath>
#include <ostream>

#include "base/words.h"
#include "tests/twin/twin_bench.h"

namespace hystcan::twin {

/// gtest finds this function by the namespace of node::WatchdogAction.
inline void PrintTo(node::WatchdogAction action, std::ostream* out) { *out << word_of(action); }

}  // namespace hystcan::twin

namespace hystcan::twin::watchdog_test {
namespace {

using can::AmpState;
using std::chrono::microseconds;
using std::chrono::milliseconds;

Config with(node::WatchdogAction action) {
  Config config = one_axis();
  AxisConfig& axis = config.axes.front().axis;
  axis.watchdog_action = action;
  axis.plant.amplifier.safe_drive = 10.0;
  axis.plant.amplifier.ramp_per_s = 200.0;
  axis.plant.amplifier.load_uF = 1.5;
  axis.plant.amplifier.load_ohm = 1e5;  // 150 ms
  return config;
}

/// Drives to 60 V, then trips. The output is read 5 ms later.
class Tripped : private TwinBench {
 public:
  explicit Tripped(node::WatchdogAction action) : TwinBench(with(action)) {
    start_nodes();
    drive(60.0, 30);
    while (status_->state != AmpState::fault) run(microseconds(10));
    tripped_ = clock_.now();
  }
  /// Returns the output at this time after the trip.
  double output_after(can::Duration duration) {
    clock_.run_until(tripped_ + duration - milliseconds(5));
    return output();
  }
  double output_after_nmt(can::NmtCommand nmt) {
    tester_->send(can::nmt_frame({nmt, 1}));
    return output();
  }
  void clear() {
    sync();
    command(0.0, false, true);
    run(milliseconds(1));
  }
  using TwinBench::drive;
  using TwinBench::emergencies_;
  using TwinBench::output;
  using TwinBench::status_;

 private:
  can::Time tripped_;
};

TEST(Watchdog, JumpsToTheSafeDriveByDefault) {
  EXPECT_EQ(AxisConfig{}.watchdog_action, node::WatchdogAction::safe);
  EXPECT_NEAR(Tripped(node::WatchdogAction::safe).output_after(milliseconds(10)), 10.0, 1e-3);
}

TEST(Watchdog, HoldsTheLastSetpoint) {
  EXPECT_NEAR(Tripped(node::WatchdogAction::hold).output_after(milliseconds(500)), 60.0, 1e-6);
}

// Emergency and status take 0.24 ms on the wire (48 mV of the ramp) before the test receives the trip.
TEST(Watchdog, RampsToTheSafeDrive) {
  Tripped drive(node::WatchdogAction::ramp);
  EXPECT_NEAR(drive.output_after(milliseconds(100)), 60.0 - 200.0 * 0.1, 0.06);
  EXPECT_NEAR(drive.output_after(milliseconds(200)), 60.0 - 200.0 * 0.2, 0.06);
  EXPECT_NEAR(drive.output_after(milliseconds(300)), 10.0, 1e-3);
}

// 0.24 ms is 0.16 % of the time constant.
TEST(Watchdog, SwitchesOffAndLeavesTheOutputToItsLoad) {
  Tripped drive(node::WatchdogAction::off);
  EXPECT_NEAR(drive.output_after(milliseconds(150)), 60.0 * std::exp(-1.0), 0.06);
  EXPECT_NEAR(drive.output_after(milliseconds(3000)), 0.0, 1e-6) << "zero, not the safe drive";
}

class EveryWatchdogAction : public testing::TestWithParam<node::WatchdogAction> {};

TEST_P(EveryWatchdogAction, IsReportedLatchedAndClearedEqually) {
  Tripped drive(GetParam());
  EXPECT_EQ(drive.status_->fault, can::amp_fault::command_timeout);
  EXPECT_EQ(drive.emergencies_, std::vector<int>{0x8130});
  drive.drive(40.0, 20);
  EXPECT_EQ(drive.status_->state, AmpState::fault) << "commands alone do not clear it";
  EXPECT_GT(std::abs(drive.output() - 40.0), 1.0);
  drive.clear();
  EXPECT_EQ(drive.status_->state, AmpState::ready);
  EXPECT_EQ(drive.emergencies_, (std::vector<int>{0x8130, 0x0000}));
  EXPECT_NEAR(drive.output(), 10.0, 1e-3) << "ready: the safe drive, at once";
  drive.drive(40.0, 20);
  EXPECT_EQ(drive.status_->state, AmpState::enabled);
  EXPECT_NEAR(drive.output(), 40.0, 1e-3);
}

TEST_P(EveryWatchdogAction, IsOverriddenByNmt) {
  EXPECT_NEAR(Tripped(GetParam()).output_after_nmt(can::NmtCommand::stop), 10.0, 1e-3);
}

TEST_P(EveryWatchdogAction, IsNotUsedForASetpointOutOfRange) {
  TwinBench bench(with(GetParam()));
  bench.start_nodes();
  bench.drive(60.0, 5);
  bench.sync();
  bench.command(121.0, true);
  EXPECT_NEAR(bench.output(), 10.0, 1e-3) << "a setpoint out of range leads to the safe drive";
}

INSTANTIATE_TEST_SUITE_P(Twin, EveryWatchdogAction, testing::ValuesIn(every<node::WatchdogAction>()),
                         [](const auto& test) { return std::string(word_of(test.param)); });

TEST(Apply, OnReceiptTakesEffectWithoutASync) {
  Config config = one_axis();
  config.axes.front().axis.apply = node::Apply::receipt;
  TwinBench bench(config);
  bench.start_nodes();
  bench.sync();
  bench.command(50.0, true);
  EXPECT_NEAR(bench.output(), 50.0, 1e-3);
  bench.sync();
  bench.command(20.0, true);
  EXPECT_NEAR(bench.output(), 20.0, 1e-3);
}

TEST(Apply, RoundsTheSetpointToTheResolutionOfTheAmplifier) {
  Config config = one_axis();
  config.axes.front().axis.plant.amplifier.resolution = 0.5;
  TwinBench bench(config);
  bench.start_nodes();
  bench.drive(50.2, 5);
  EXPECT_NEAR(bench.output(), 50.0, 1e-6);
}

}  // namespace
}  // namespace hystcan::twin::watchdog_test
