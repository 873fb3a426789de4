// The amplifier's node at its bounds, observed at the bus: the frames that it receives and obeys, the action
// of its watchdog, and its reports.
#include <gtest/gtest.h>

#include <span>
#include <utility>
#include <vector>

#include "can/protocol/sdo.h"
#include "tests/support/shows.h"
#include "tests/twin/twin_bench.h"

namespace hystcan::twin::amplifier_node_test {
namespace {

using can::AmpState;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr can::SdoObject object{.index = 0x2001, .subindex = 1};

class AmplifierOnBus : public testing::Test, protected TwinBench {
 protected:
  AmplifierOnBus() {
    tester_->on_frame([this](const can::Frame& frame, can::Time received) {
      if (frame.id == 0x181) {
        ++statuses_;
        status_ = decode_status_(frame);
      }
      if (frame.id == 0x081) emergency_frames_.push_back(frame);
      if (frame.id == 0x081) tripped_ = received;
      if (frame.id == 0x581) ++sdo_responses_;
      if (frame.id == 0x701) amplifier_heartbeats_.push_back(frame.data[0]);
    });
  }
  node::AmplifierChannel& amplifier() { return twin_.axes().front()->amplifier; }
  void nmt(can::NmtCommand command) {
    tester_->send(can::nmt_frame({command, 1}));
    run(milliseconds(1));
  }
  /// Returns true if the node answers an SDO request.
  bool answers() {
    sdo_responses_ = 0;
    tester_->send(can::sdo_request(
        1, {.service = can::SdoService::write, .object = object, .content = {.value = 140, .bytes = 2}}));
    run(milliseconds(1));
    return sdo_responses_ > 0;
  }
  void clear() {
    sync();
    command(0.0, false, true);
    run(milliseconds(1));
  }

  int statuses_ = 0;
  int sdo_responses_ = 0;
  can::Time tripped_{};
  std::vector<can::Frame> emergency_frames_;
};

TEST(AmplifierFilters, AreNmtSyncItsOwnHeartbeatItsObjectsAndItsCommand) {
  can::VirtualClock clock;
  can::SimBus bus(clock, {1'000'000});
  std::vector<std::vector<std::uint32_t>> attached;
  const can::Database database = can::load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  const Twin twin(one_axis(), database, clock, [&](std::span<const can::Filter> filters) {
    attached.emplace_back();
    for (const can::Filter& filter : filters) attached.back().push_back(filter.id);
    return bus.attach();
  });
  ASSERT_FALSE(attached.empty());
  EXPECT_EQ(attached.front(), (std::vector<std::uint32_t>{0x000, 0x080, 0x701, 0x601, 0x201}));
}

// ---- objects

TEST_F(AmplifierOnBus, AnswersForItsObjectsUnlessNmtHasStoppedIt) {
  EXPECT_TRUE(answers()) << "pre-operational";
  start_nodes();
  EXPECT_TRUE(answers());
  nmt(can::NmtCommand::stop);
  EXPECT_FALSE(answers());
  nmt(can::NmtCommand::enter_pre_operational);
  EXPECT_TRUE(answers());
}

TEST_F(AmplifierOnBus, IsSilentAndOffIfAnotherNodeHasItsNumber) {
  shows("S-155");
  start_nodes();
  drive(50.0, 5);
  statuses_ = 0;
  tester_->send(can::heartbeat_frame(1, can::NmtState::operational));
  run(milliseconds(1));
  EXPECT_TRUE(amplifier().node().is_taken());
  EXPECT_FALSE(amplifier().node().is_on_the_bus());
  amplifier_heartbeats_.clear();
  EXPECT_FALSE(answers());
  amplifier().node().restart();
  start_nodes();
  drive(50.0, 50);
  run(milliseconds(250));
  amplifier().node().shut_down();
  run(milliseconds(1));
  EXPECT_EQ(statuses_, 0);
  EXPECT_TRUE(amplifier_heartbeats_.empty()) << "also after a return of the supply";
  EXPECT_NEAR(output(), 0.0, 1e-3);
}

// ---- commands

TEST_F(AmplifierOnBus, AcceptsBothBoundsOfItsRange) {
  shows("S-133");
  start_nodes();
  for (const double bound : {-20.0, 120.0}) {
    drive(bound, 5);
    EXPECT_EQ(status_->state, AmpState::enabled);
    EXPECT_NEAR(output(), bound, 1e-3);
  }
}

TEST_F(AmplifierOnBus, TripsBelowItsRange) {
  start_nodes();
  drive(-20.1, 1);
  EXPECT_EQ(status_->state, AmpState::fault);
  EXPECT_EQ(status_->fault, can::amp_fault::setpoint_out_of_range);
}

/// Sends the command for this SYNC after `later` further SYNCs.
TEST_F(AmplifierOnBus, ObeysCommandsOfTheLastTwoSyncs) {
  shows("S-115");
  start_nodes();
  for (int i = 0; i < 500; ++i) {
    drive(1.0, 1);
    const std::uint8_t named = counter_;
    sync();
    run(microseconds(200));
    const double setpoint = 10.0 + i % 50;
    tester_->send(*encode_command_({.setpoint = setpoint, .enable = true, .sync_counter = named}));
    run(microseconds(300));
    ASSERT_EQ(amplifier().setpoint(), setpoint) << "SYNC " << int{named};
    sync();
    run(microseconds(200));
    tester_->send(*encode_command_({.setpoint = 99.0, .enable = true, .sync_counter = named}));
    run(microseconds(300));
    ASSERT_EQ(amplifier().setpoint(), setpoint) << "two SYNCs old";
  }
}

TEST_F(AmplifierOnBus, AcceptsAnyCounterOfACommandAfterNmtStart) {
  shows("S-080");
  start_nodes();
  cycle();
  const can::Frame first = *encode_command_({.setpoint = 10.0, .enable = true, .sync_counter = counter_});
  tester_->send(first);
  run(milliseconds(1));
  ASSERT_EQ(status_->state, AmpState::enabled);
  nmt(can::NmtCommand::stop);
  start_nodes();
  tester_->send(can::sync_frame(counter_));
  tester_->send(first);
  run(milliseconds(1));
  EXPECT_EQ(status_->state, AmpState::enabled) << "the same counter again";
}

TEST_F(AmplifierOnBus, IgnoresCommandsBeforeItIsOperational) {
  shows("S-111");
  sync();
  command(50.0, true);
  run(milliseconds(1));
  EXPECT_EQ(amplifier().state(), AmpState::off);
  EXPECT_EQ(amplifier().setpoint(), 0.0);
}

TEST_F(AmplifierOnBus, IgnoresCommandsAfterAResetBeforeASync) {
  shows("S-119");
  start_nodes();
  drive(10.0, 5);
  nmt(can::NmtCommand::reset_node);
  start_nodes();
  for (const std::uint8_t named : {std::uint8_t{1}, counter_}) {
    tester_->send(*encode_command_({.setpoint = 50.0, .enable = true, .sync_counter = named}));
    run(milliseconds(1));
    EXPECT_EQ(amplifier().state(), AmpState::ready) << "it names SYNC " << int{named};
  }
}

TEST_F(AmplifierOnBus, IgnoresCommandsAfterAResetForAnEarlierSync) {
  shows("S-119");
  start_nodes();
  sync();  // 1
  run(microseconds(100));
  tester_->send(can::nmt_frame({can::NmtCommand::reset_node, 1}));
  run(microseconds(300));
  tester_->send(can::nmt_frame({can::NmtCommand::start, 1}));
  run(microseconds(300));
  ASSERT_EQ(amplifier().state(), AmpState::ready);
  tester_->send(*encode_command_({.setpoint = 50.0, .enable = true, .sync_counter = 1}));
  run(microseconds(300));
  EXPECT_EQ(amplifier().state(), AmpState::ready) << "1 ms behind the SYNC";
}

/// Frames without Enable and status.
Config bare_frames() {
  Config config = one_axis();
  config.axes.front().wire.frames =
      can::AxisFrames{.command = {.message = "XAmpCommand",
                                  .signals = {{"setpoint", "Setpoint"}, {"sync_counter", "SyncCounter"}}},
                      .sample = {.message = "XSensorSample", .signals = {{"position", "Position"}}}};
  return config;
}

TEST(AmplifierWithBareFrames, IsEnabledByACommandAloneAndSendsNoStatus) {
  TwinBench bench(bare_frames());
  bench.start_nodes();
  bench.sync();
  bench.command(50.0, false);
  bench.run(milliseconds(1));
  bench.cycle();
  EXPECT_EQ(bench.twin_.axes().front()->amplifier.state(), AmpState::enabled);
  EXPECT_NEAR(bench.output(), 50.0, 1e-3);
  bench.drive(50.0, 30);
  EXPECT_EQ(bench.heard_[0x181], 0);
}

// Falls at 1000 V/s for 21.7 ms; 0.5 V are due to the frames and the bandwidth.
TEST(AmplifierStatus, HasTheOutputAtItsOwnTime) {
  shows("S-144");
  Config config = one_axis();
  config.axes.front().axis.plant.amplifier.slew_per_s = 1000.0;
  config.axes.front().axis.command_timeout = milliseconds(200);
  TwinBench bench(config);
  bench.start_nodes();
  bench.drive(50.0, 100);
  bench.command(0.0, false);
  bench.run(milliseconds(20));
  bench.sync();
  bench.run(microseconds(1700));
  bench.command(0.0, true);
  bench.run(milliseconds(1));
  ASSERT_EQ(bench.status_->state, AmpState::enabled);
  EXPECT_NEAR(bench.status_->output, 28.3, 0.5);
}

// The output follows at 1000 V/s from the arrival of the command; 0.5 V are due to the frame and the
// bandwidth.
TEST(AmplifierOnReceipt, TurnsItsOutputAtTheArrivalOfTheCommand) {
  Config config = one_axis();
  config.axes.front().axis.apply = node::Apply::receipt;
  config.axes.front().axis.plant.amplifier.slew_per_s = 1000.0;
  TwinBench bench(config);
  bench.start_nodes();
  for (int i = 0; i < 8; ++i) {
    bench.sync();
    bench.command(50.0, true);
    bench.run(milliseconds(15));
  }
  bench.sync();
  bench.run(microseconds(1700));  // the sensor has read the stage at the SYNC
  bench.command(20.0, true);
  EXPECT_NEAR(bench.output(), 45.0, 0.5) << "5 ms later";
}

TEST_F(AmplifierOnBus, IsReadyAtTheSafeDriveWithoutEnable) {
  start_nodes();
  drive(50.0, 5);
  sync();
  command(50.0, false);
  EXPECT_NEAR(output(), 0.0, 1e-3);
  EXPECT_EQ(status_->state, AmpState::ready);
}

// ---- the watchdog

/// Time from the last command's arrival to the emergency on the wire.
TEST_F(AmplifierOnBus, TripsAtItsTimeoutAfterTheLastCommand) {
  shows("S-127");
  start_nodes();
  drive(50.0, 30);
  const can::Time last = clock_.now() - milliseconds(1);  // time of the last command
  run(milliseconds(40));
  ASSERT_EQ(emergency_frames_.size(), 1u);
  const auto after = tripped_ - last;
  EXPECT_GT(after, milliseconds(20));
  EXPECT_LT(after, milliseconds(20) + microseconds(500)) << "three frames on the wire";
}

TEST_F(AmplifierOnBus, DoesNotTripWhileCommandsArriveWithinTheTimeout) {
  shows("S-127");
  start_nodes();
  for (int i = 0; i < 20; ++i) {
    sync();
    command(50.0, true);
    run(milliseconds(19));
    ASSERT_EQ(status_->state, AmpState::enabled);
  }
  EXPECT_TRUE(emergency_frames_.empty());
}

TEST_F(AmplifierOnBus, DoesNotTripIfItIsSwitchedOffInTime) {
  shows("S-128");
  start_nodes();
  drive(50.0, 5);
  sync();
  command(0.0, false);
  run(milliseconds(100));
  EXPECT_TRUE(emergency_frames_.empty());
  EXPECT_EQ(status_->state, AmpState::ready);
}

TEST_F(AmplifierOnBus, ReportsACommandTimeoutAsAGenericEmergency) {
  shows("S-129");
  start_nodes();
  drive(50.0, 5);
  run(milliseconds(50));
  ASSERT_EQ(emergency_frames_.size(), 1u);
  const auto emergency = can::parse_emergency(emergency_frames_.front());
  EXPECT_EQ(emergency->code, 0x8130);
  EXPECT_EQ(emergency->error_register, 0x01);
}

TEST_F(AmplifierOnBus, ReportsASetpointOutOfRangeAsADataSetEmergency) {
  shows("S-130");
  start_nodes();
  drive(121.0, 1);
  ASSERT_EQ(emergency_frames_.size(), 1u);
  EXPECT_EQ(can::parse_emergency(emergency_frames_.front())->code, 0x6300);
}

// ---- an internal cause

TEST_F(AmplifierOnBus, ReportsAnInternalCauseAsAHardwareEmergency) {
  shows("S-131");
  start_nodes();
  drive(50.0, 5);
  amplifier().begin_internal_fault();
  run(milliseconds(1));
  EXPECT_EQ(status_->state, AmpState::fault);
  EXPECT_EQ(status_->fault, node::internal_fault);
  ASSERT_EQ(emergency_frames_.size(), 1u);
  EXPECT_EQ(can::parse_emergency(emergency_frames_.front())->code, 0x5000);
  EXPECT_NEAR(output(), 0.0, 1e-3);
}

TEST_F(AmplifierOnBus, KeepsAnEarlierFaultBesideAnInternalCause) {
  start_nodes();
  drive(50.0, 5);
  run(milliseconds(50));
  amplifier().begin_internal_fault();
  EXPECT_EQ(amplifier().fault(), can::amp_fault::command_timeout | node::internal_fault);
}

TEST_F(AmplifierOnBus, ClearsAFaultOnlyAfterItsInternalCauseHasEnded) {
  shows("S-137");
  start_nodes();
  amplifier().begin_internal_fault();
  clear();
  EXPECT_EQ(status_->state, AmpState::fault);
  amplifier().end_internal_fault();
  run(milliseconds(1));
  EXPECT_EQ(status_->state, AmpState::fault) << "latched";
  clear();
  EXPECT_EQ(status_->state, AmpState::ready);
  EXPECT_EQ(status_->fault, 0);
}

TEST_F(AmplifierOnBus, ReportsAnEarlierInternalCauseAfterItsStart) {
  shows("S-140");
  amplifier().begin_internal_fault();
  run(milliseconds(1));
  EXPECT_TRUE(emergency_frames_.empty());
  start_nodes();
  EXPECT_EQ(status_->state, AmpState::fault);
  EXPECT_EQ(status_->fault, node::internal_fault);
}

TEST_F(AmplifierOnBus, ClearsAFaultAtAResetUnlessItsCausePersists) {
  shows("S-100");
  start_nodes();
  drive(50.0, 5);
  run(milliseconds(50));
  ASSERT_EQ(amplifier().fault(), can::amp_fault::command_timeout);
  nmt(can::NmtCommand::reset_node);
  EXPECT_EQ(amplifier().fault(), 0);
  start_nodes();
  EXPECT_EQ(status_->state, AmpState::ready);

  amplifier().begin_internal_fault();
  nmt(can::NmtCommand::reset_node);
  start_nodes();
  EXPECT_EQ(status_->state, AmpState::fault);
  EXPECT_EQ(status_->fault, node::internal_fault);
}

// ---- the status

TEST_F(AmplifierOnBus, SendsAStatusAtTheTenthSyncAfterItsLastOne) {
  shows("S-145");
  start_nodes();
  drive(10.0, 1);  // the change to enabled is reported
  for (int round = 0; round < 3; ++round) {
    statuses_ = 0;
    drive(10.0, 9);
    EXPECT_EQ(statuses_, 0);
    drive(10.0, 1);
    EXPECT_EQ(statuses_, 1);
  }
}

TEST_F(AmplifierOnBus, SendsNoStatusAtASyncBeforeItIsOperational) {
  shows("S-146");
  for (int i = 0; i < 50; ++i) cycle();
  EXPECT_EQ(statuses_, 0);
}

TEST_F(AmplifierOnBus, CountsItsStatusesFromZeroAfterAReset) {
  start_nodes();
  drive(10.0, 35);
  std::vector<int> counters;
  tester_->on_frame([&](const can::Frame& frame, can::Time) {
    if (frame.id == 0x181) counters.push_back(frame.data[6]);
  });
  nmt(can::NmtCommand::reset_node);
  start_nodes();
  EXPECT_EQ(counters, std::vector{0}) << "ready; a node that boots up sends no status";
}

}  // namespace
}  // namespace hystcan::twin::amplifier_node_test
