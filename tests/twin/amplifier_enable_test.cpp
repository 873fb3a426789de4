// From Enable to enabled: the relay and the soft start of the amplifier's node, observed at the bus.
#include <gtest/gtest.h>

#include "tests/support/shows.h"
#include "tests/twin/twin_bench.h"

namespace hystcan::twin::amplifier_enable_test {
namespace {

using can::AmpState;
using std::chrono::microseconds;
using std::chrono::milliseconds;

/// Commands may stop for 20 ms. If `slow`, the output can rise or fall by 1 V per millisecond.
struct Way {
  can::Duration enable_delay{};
  can::Duration soft_start{};
  node::Apply apply = node::Apply::sync;
  can::Duration command_timeout = milliseconds(20);
  bool slow = false;
};

Config with(const Way& way) {
  Config config = one_axis();
  auto& axis = config.axes.front().axis;
  axis.enable_delay = way.enable_delay;
  axis.soft_start = way.soft_start;
  axis.apply = way.apply;
  axis.command_timeout = way.command_timeout;
  if (way.slow) axis.plant.amplifier.slew_per_s = 1000.0;
  return config;
}

/// Makes the nodes operational.
struct EnableBench : TwinBench {
  explicit EnableBench(const Way& way) : TwinBench(with(way)) {
    listener->on_frame(
        [this](const can::Frame& frame, can::Time received) { arrivals[frame.id] = received; });
    start_nodes();
  }
  AmpState state() { return twin_.axes().front()->amplifier.state(); }
  /// Returns the present output; advances the plant to the present time.
  double drive_now() {
    Plant& plant = twin_.axes().front()->plant;
    plant.advance_to(clock_.now());
    return plant.drive();
  }
  /// Returns the arrival time of the command.
  can::Time enable(double setpoint) {
    command(setpoint, true);
    run(milliseconds(1));
    return arrivals[0x201];
  }
  void sync_that_arrives_at(can::Time time) {
    sync();
    const can::Time sent = clock_.now();
    run(milliseconds(1));
    const can::Duration on_the_wire = arrivals[can::sync_id] - sent;
    clock_.run_until(time - on_the_wire);
    --counter_;  // the same frame again takes the same time
    cycle();
    EXPECT_EQ(arrivals[can::sync_id], time);
  }

  std::unique_ptr<can::Bus> listener = bus_.attach();
  std::map<std::uint32_t, can::Time> arrivals;
};

// ---- the relay

TEST(AmplifierRelay, ConnectsTheOutputAfterItsDelayFromTheFirstCommand) {
  EnableBench bench({.enable_delay = milliseconds(10)});
  bench.drive(50.0, 10);
  EXPECT_EQ(bench.state(), AmpState::ready);
  EXPECT_EQ(bench.drive_now(), 0.0);
  bench.drive(50.0, 1);
  EXPECT_EQ(bench.state(), AmpState::enabled);
}

TEST(AmplifierRelay, DoesNotCloseIfTheAmplifierIsSwitchedOff) {
  shows("S-125");
  EnableBench bench({.enable_delay = milliseconds(10)});
  bench.drive(50.0, 9);
  bench.sync();
  bench.command(0.0, false);
  bench.run(milliseconds(5));
  EXPECT_EQ(bench.state(), AmpState::ready);
  bench.drive(50.0, 10);
  EXPECT_EQ(bench.state(), AmpState::ready) << "the whole delay again";
  bench.drive(50.0, 1);
  EXPECT_EQ(bench.state(), AmpState::enabled);
}

TEST(AmplifierRelay, DoesNotDriveIfTheCommandsHaveStopped) {
  shows("S-126");
  EnableBench bench({.enable_delay = milliseconds(25)});
  bench.drive(50.0, 1);
  bench.run(milliseconds(30));
  EXPECT_EQ(bench.state(), AmpState::ready);
  bench.drive(50.0, 26);
  EXPECT_EQ(bench.state(), AmpState::enabled) << "it begins again";
}

TEST(AmplifierRelay, DoesNotDriveIfTheCommandsStopAsItCloses) {
  shows("S-126");
  EnableBench bench({.enable_delay = milliseconds(20)});
  bench.drive(50.0, 1);
  bench.run(milliseconds(30));
  EXPECT_EQ(bench.state(), AmpState::ready);
  EXPECT_TRUE(bench.emergencies_.empty());
}

TEST(AmplifierRelay, ReportsAtOnceThatItHasClosed) {
  EnableBench bench({.enable_delay = milliseconds(10)});
  bench.drive(50.0, 1);
  bench.run(milliseconds(12));
  ASSERT_TRUE(bench.status_);
  EXPECT_EQ(bench.status_->state, AmpState::enabled);
}

TEST(AmplifierRelay, AppliesTheSetpointAtTheNextSync) {
  shows("S-123");
  EnableBench bench({.enable_delay = milliseconds(10)});
  bench.drive(50.0, 1);
  bench.run(milliseconds(12));
  ASSERT_EQ(bench.state(), AmpState::enabled);
  EXPECT_EQ(bench.drive_now(), 0.0);
  bench.sync();
  EXPECT_NEAR(bench.output(), 50.0, 1e-3);
}

TEST(AmplifierRelay, UsesTheLastSetpointBeforeTheSync) {
  shows("S-123");
  EnableBench bench({.enable_delay = microseconds(1200)});
  bench.drive(50.0, 1);
  bench.command(20.0, true);  // while it closes
  bench.run(microseconds(600));
  ASSERT_EQ(bench.state(), AmpState::enabled);
  bench.command(30.0, true);
  bench.run(milliseconds(1));
  EXPECT_EQ(bench.drive_now(), 0.0);
  bench.sync();
  EXPECT_NEAR(bench.output(), 30.0, 1e-3);
}

TEST(AmplifierRelay, AppliesTheSetpointAtOnceIfAppliedOnReceipt) {
  EnableBench bench({.enable_delay = milliseconds(10), .apply = node::Apply::receipt});
  bench.drive(50.0, 1);
  bench.run(milliseconds(12));
  ASSERT_EQ(bench.state(), AmpState::enabled);
  EXPECT_NEAR(bench.drive_now(), 50.0, 1e-3);
}

// ---- the soft start

TEST(AmplifierSoftStart, RampsToItsSetpointAndIsThenEnabled) {
  shows("S-124");
  EnableBench bench({.soft_start = milliseconds(100)});
  bench.drive(50.0, 50);
  EXPECT_NEAR(bench.drive_now(), 25.0, 1.0) << "0.5 V in a cycle";
  bench.drive(50.0, 49);
  EXPECT_EQ(bench.state(), AmpState::ready);
  bench.drive(50.0, 4);  // the setpoint acts at the SYNC after the last one of the soft start
  EXPECT_EQ(bench.state(), AmpState::enabled);
  EXPECT_NEAR(bench.drive_now(), 50.0, 1e-3);
}

TEST(AmplifierSoftStart, EndsWithASyncAtItsEnd) {
  shows("S-124");
  EnableBench bench({.soft_start = milliseconds(20), .command_timeout = milliseconds(200)});
  bench.cycle();
  bench.sync_that_arrives_at(bench.enable(50.0) + milliseconds(20));
  EXPECT_EQ(bench.state(), AmpState::enabled);
}

TEST(AmplifierSoftStart, CountsTheSyncAtItsEndForTheNextStatus) {
  EnableBench bench({.soft_start = milliseconds(5)});
  for (int i = 0; i < 20 && bench.state() != AmpState::enabled; ++i) bench.drive(50.0, 1);
  const int before = bench.heard_[0x181];
  bench.drive(50.0, 8);
  EXPECT_EQ(bench.heard_[0x181], before);
  bench.drive(50.0, 1);
  EXPECT_EQ(bench.heard_[0x181], before + 1);
}

TEST(AmplifierSoftStart, EndsAtTheSafeDriveIfTheCommandsStop) {
  EnableBench bench({.soft_start = milliseconds(100)});
  bench.drive(50.0, 50);
  for (int i = 0; i < 25; ++i) bench.cycle();
  EXPECT_NEAR(bench.drive_now(), 0.0, 1e-3);
  EXPECT_EQ(bench.state(), AmpState::ready);
  bench.drive(50.0, 50);
  EXPECT_NEAR(bench.drive_now(), 25.0, 1.0) << "it begins again";
}

TEST(AmplifierSoftStart, EndsWithASyncAtTheCommandTimeout) {
  EnableBench bench({.soft_start = milliseconds(100)});
  bench.cycle();
  bench.sync_that_arrives_at(bench.enable(50.0) + milliseconds(20));
  EXPECT_NEAR(bench.drive_now(), 0.0, 1e-3);
}

TEST(AmplifierSoftStart, EndsIfTheAmplifierIsSwitchedOff) {
  shows("S-125");
  EnableBench bench({.soft_start = milliseconds(100)});
  bench.drive(50.0, 50);
  bench.sync();
  bench.command(0.0, false);
  bench.run(milliseconds(1));
  bench.cycle();
  EXPECT_NEAR(bench.drive_now(), 0.0, 1e-3);
}

// The output has fallen for 21.7 ms from 50 V, the last 1.7 ms after the last SYNC. 0.5 V are due to the
// frames and the soft start.
TEST(AmplifierSoftStart, BeginsAtThePresentOutput) {
  EnableBench bench({.soft_start = milliseconds(100), .command_timeout = milliseconds(200), .slow = true});
  bench.drive(50.0, 200);
  ASSERT_EQ(bench.state(), AmpState::enabled);
  bench.command(0.0, false);
  bench.run(milliseconds(20));
  bench.sync();
  bench.run(microseconds(1700));
  bench.command(50.0, true);
  bench.run(milliseconds(1));
  bench.sync();
  EXPECT_NEAR(bench.output(), 28.3, 0.5);
}

// The target is 30 V at the SYNC, 60 ms after Enable. 0.5 V are due to the frame and the bandwidth.
TEST(AmplifierSoftStart, MovesTheTargetAtTheArrivalOfTheSync) {
  EnableBench bench({.soft_start = milliseconds(100), .command_timeout = milliseconds(200), .slow = true});
  bench.tester_->send(can::nmt_frame({can::NmtCommand::stop, 2}));  // otherwise the sensor reads the stage
  bench.drive(50.0, 1);
  bench.run(milliseconds(60));
  bench.sync();
  EXPECT_NEAR(bench.output(), 5.0, 0.5) << "5 ms later";
}

}  // namespace
}  // namespace hystcan::twin::amplifier_enable_test
