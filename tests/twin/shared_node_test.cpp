// Two axes in one CAN FD frame: the shared and the separate functions of their nodes.
#include <gtest/gtest.h>

#include "can/protocol/sdo.h"
#include "tests/support/shows.h"
#include "tests/twin/shared_bench.h"

namespace hystcan::twin::shared_node_test {
namespace {

using can::AmpState;
using std::chrono::milliseconds;

class SharedNode : public testing::Test, protected SharedBench {
 protected:
  SharedNode() { start_nodes(); }
};

// ---- shared by the axes

TEST(SharedNodes, BootUpOnceAndSendOneHeartbeatEach) {
  SharedBench bench;
  bench.run(milliseconds(1));
  for (const std::uint32_t id : {0x701u, 0x702u}) EXPECT_EQ(bench.heard_[id], 1) << "boot-up";
  bench.run(milliseconds(200));
  for (const std::uint32_t id : {0x701u, 0x702u}) EXPECT_EQ(bench.heard_[id], 3);
  EXPECT_EQ(bench.twin_.station().connections().size(), 2u);
}

TEST_F(SharedNode, AnswersAnSdoRequestOnce) {
  tester_->send(can::sdo_request(1, {.service = can::SdoService::write,
                                     .object = {.index = 0x2001, .subindex = 1},
                                     .content = {.value = 140, .bytes = 2}}));
  run(milliseconds(1));
  EXPECT_EQ(heard_[0x581], 1);
  EXPECT_EQ(amplifier(y).node().objects().object({.index = 0x2001, .subindex = 1})->value, 140u);
}

TEST_F(SharedNode, ASampleFrameHoldsBothPositionsAndOneSyncCounter) {
  drive(60.0, 20.0, 20);
  heard_.clear();
  cycle();
  EXPECT_EQ(heard_[0x182], 1);
  ASSERT_TRUE(samples_[x] && samples_[y]);
  EXPECT_NEAR(samples_[x]->position_um, axis(x).plant.position_um(), 0.05);
  EXPECT_NEAR(samples_[y]->position_um, axis(y).plant.position_um(), 0.05);
  EXPECT_GT(samples_[x]->position_um, 2.0 * samples_[y]->position_um);
  EXPECT_EQ(samples_[x]->sync_counter, counter_);
  EXPECT_EQ(samples_[y]->sync_counter, counter_);
}

TEST_F(SharedNode, ACommandFrameMovesBothAxes) {
  drive(60.0, -10.0);
  EXPECT_NEAR(axis(x).plant.drive(), 60.0, 0.1);
  EXPECT_NEAR(axis(y).plant.drive(), -10.0, 0.1);
}

TEST_F(SharedNode, ARejectedCommandFrameMovesNoAxis) {
  shows("S-079");
  drive(60.0, -10.0);
  sync();
  can::Frame frame = command_[x].frame();
  for (const std::size_t axis : {x, y})
    ASSERT_TRUE(command_[axis].put({.setpoint = 5.0, .enable = true, .sync_counter = counter_}, frame));
  tester_->send(frame);  // without its CRC
  run(milliseconds(1));
  EXPECT_EQ(amplifier(x).setpoint(), 60.0);
  EXPECT_EQ(amplifier(y).setpoint(), -10.0);
  EXPECT_EQ(amplifier(x).node().checker().rejected(can::Rejection::wrong_crc), 1u);
}

TEST_F(SharedNode, ReportsAChangeOfBothAxesInOneStatus) {
  heard_.clear();
  sync();
  command({can::AmpCommand{.enable = true}, can::AmpCommand{.enable = true}});
  run(milliseconds(1));
  EXPECT_EQ(heard_[0x181], 1);
  EXPECT_EQ(statuses_[x]->state, AmpState::enabled);
  EXPECT_EQ(statuses_[y]->state, AmpState::enabled);
}

TEST_F(SharedNode, SendsItsPeriodicStatusOnceForBothAxes) {
  drive(60.0, 20.0);
  heard_.clear();
  drive(60.0, 20.0, 20);
  EXPECT_EQ(heard_[0x181], 2);
}

TEST(SharedSensor, HasOneClockForAllItsAxes) {
  Config config = two_axes();
  config.axes[1].axis.sample_clock = {.sampling = node::Sampling::free, .rate_Hz = 1000.0};
  EXPECT_THROW(SharedBench{config}, std::invalid_argument);
  config.axes[0].axis.sample_clock = config.axes[1].axis.sample_clock;
  SharedBench bench(config);
  bench.start_nodes();
  bench.cycle();
  bench.heard_.clear();
  bench.run(milliseconds(10));
  EXPECT_NEAR(bench.heard_[0x182], 10, 1);
}

TEST(SharedNodes, MustBelongToOneTwin) {
  EXPECT_THROW(with_axes(two_axes(), {"x"}), std::invalid_argument);
  EXPECT_EQ(with_axes(two_axes(), {"x", "y"}).axes.size(), 2u);
}

TEST_F(SharedNode, KeepsItsErrorRegisterUntilNoAxisIsFaulted) {
  drive(60.0, 20.0);
  run(milliseconds(40));
  EXPECT_EQ(emergency_.code, 0x8130);
  drive({can::AmpCommand{.clear_fault = true}, can::AmpCommand{}}, 1);
  EXPECT_EQ(emergency_.code, 0x0000);
  EXPECT_EQ(emergency_.error_register, 0x01) << "y is faulted";
  drive({can::AmpCommand{}, can::AmpCommand{.clear_fault = true}}, 1);
  EXPECT_EQ(emergency_.error_register, 0x00);
}

// ---- separate for each axis

TEST_F(SharedNode, AnOldCommandFrameCanOnlySwitchOff) {
  drive(60.0, 20.0);
  sync();
  run(milliseconds(3));
  command({can::AmpCommand{.setpoint = 50.0, .enable = true}, can::AmpCommand{}});
  run(milliseconds(1));
  EXPECT_EQ(amplifier(x).setpoint(), 60.0);
  EXPECT_EQ(amplifier(x).state(), AmpState::enabled);
  EXPECT_EQ(amplifier(y).state(), AmpState::ready);
}

TEST_F(SharedNode, TripsTheWatchdogOfEachAxisWithoutCommands) {
  drive(60.0, 20.0);
  heard_.clear();
  run(milliseconds(40));
  EXPECT_EQ(heard_[0x181], 1) << "one status reports both";
  EXPECT_EQ(heard_[0x081], 1) << "and one emergency";
  for (const std::size_t axis : {x, y}) {
    EXPECT_EQ(statuses_[axis]->state, AmpState::fault);
    EXPECT_EQ(statuses_[axis]->fault, can::amp_fault::command_timeout);
  }
}

TEST(SharedAmplifier, HasAWatchdogForEachAxis) {
  Config config = two_axes();
  config.axes[1].axis.command_timeout = milliseconds(50);
  SharedBench bench(config);
  bench.start_nodes();
  bench.drive(60.0, 20.0);
  bench.run(milliseconds(40));
  EXPECT_EQ(bench.amplifier(x).state(), AmpState::fault);
  EXPECT_EQ(bench.amplifier(y).state(), AmpState::enabled);
  bench.run(milliseconds(20));
  EXPECT_EQ(bench.amplifier(y).state(), AmpState::fault);
}

TEST_F(SharedNode, AFaultOfOneAxisDoesNotAffectTheOther) {
  drive(60.0, 20.0);
  drive(60.0, 500.0, 1);  // beyond the range of y
  EXPECT_EQ(statuses_[y]->fault, can::amp_fault::setpoint_out_of_range);
  drive(50.0, 20.0);
  EXPECT_EQ(amplifier(x).state(), AmpState::enabled);
  EXPECT_EQ(amplifier(y).state(), AmpState::fault);
  EXPECT_NEAR(axis(x).plant.drive(), 50.0, 0.1);
  EXPECT_NEAR(axis(y).plant.drive(), 0.0, 0.1);
  drive({can::AmpCommand{.setpoint = 50.0, .enable = true}, can::AmpCommand{.clear_fault = true}}, 1);
  EXPECT_EQ(amplifier(x).state(), AmpState::enabled);
  EXPECT_EQ(amplifier(y).state(), AmpState::ready);
}

TEST_F(SharedNode, ADisabledAxisDoesNotAffectTheOther) {
  drive({can::AmpCommand{.setpoint = 50.0, .enable = true}, can::AmpCommand{}}, 10);
  EXPECT_EQ(amplifier(x).state(), AmpState::enabled);
  EXPECT_EQ(amplifier(y).state(), AmpState::ready);
}

TEST(SharedSensor, HasIndependentNoiseForEachAxis) {
  Config config = two_axes();
  for (WiredAxisConfig& axis : config.axes) axis.axis.sensor.noise_um_rms = 0.1;
  SharedBench bench(config);
  bench.start_nodes();
  bench.cycle();
  EXPECT_NE(bench.samples_[x]->position_um, bench.samples_[y]->position_um);
}

// ---- faults

TEST_F(SharedNode, AFaultOfTheNodeIsOneFaultForBothAxes) {
  inject(Fault::no_reply, "x", Node::sensor);
  inject(Fault::no_reply, "y", Node::sensor);
  EXPECT_EQ(twin_.faults().active().size(), 1u);
  EXPECT_EQ(twin_.faults().remove(Fault::no_reply, "x"), 1u);
  heard_.clear();
  drive(60.0, 20.0);
  EXPECT_EQ(heard_[0x182], 10);
}

TEST_F(SharedNode, ASupplyLossAffectsBothAxesAndBootsUpOnce) {
  drive(60.0, 20.0);
  inject(Fault::node_reboot, "x", Node::amplifier);
  EXPECT_EQ(amplifier(x).state(), AmpState::off);
  EXPECT_EQ(amplifier(y).state(), AmpState::off);
  run(milliseconds(1));
  heard_.clear();
  twin_.faults().remove();
  run(milliseconds(1));
  EXPECT_EQ(heard_[0x701], 1);
  EXPECT_EQ(heard_[0x181], 0) << "no status before NMT start";
}

TEST_F(SharedNode, AWrongValueOfOneAxisKeepsThatOfTheOther) {
  drive(60.0, 20.0);
  inject(Fault::frozen_value, "y", Node::sensor);
  inject(Fault::sensor_bad_status, "y", Node::sensor);
  drive(60.0, 20.0, 1);
  const double before = samples_[y]->position_um;
  drive(10.0, 80.0, 20);
  ASSERT_TRUE(samples_[x] && samples_[y]) << "counter and CRC are right";
  EXPECT_EQ(samples_[y]->position_um, before);
  EXPECT_NEAR(samples_[x]->position_um, axis(x).plant.position_um(), 0.05);
  EXPECT_EQ(samples_[x]->status, 0);
  EXPECT_NE(samples_[y]->status, 0);
}

TEST_F(SharedNode, TheSameFaultOfBothAxesHasAValueForEach) {
  inject(Fault::sensor_offset, "x", Node::sensor, 8.0);
  inject(Fault::sensor_offset, "y", Node::sensor, -5.0);
  cycle();
  EXPECT_NEAR(samples_[x]->position_um, axis(x).plant.position_um() + 8.0, 0.05);
  EXPECT_NEAR(samples_[y]->position_um, axis(y).plant.position_um() - 5.0, 0.05);
  EXPECT_EQ(twin_.faults().remove(Fault::sensor_offset, "x"), 1u);
  cycle();
  EXPECT_NEAR(samples_[x]->position_um, axis(x).plant.position_um(), 0.05);
  EXPECT_NEAR(samples_[y]->position_um, axis(y).plant.position_um() - 5.0, 0.05);
}

TEST_F(SharedNode, SaturatesAFaultTooLargeForItsSignal) {
  drive(60.0, 20.0);
  inject(Fault::amplifier_trip, "y", Node::amplifier);
  run(milliseconds(1));
  EXPECT_EQ(statuses_[y]->state, AmpState::fault);
  EXPECT_EQ(statuses_[y]->fault, 3) << "of two bits";
}

TEST_F(SharedNode, TripsOneAmplifierAloneForACauseWithinIt) {
  drive(60.0, 20.0);
  inject(Fault::amplifier_trip, "y", Node::amplifier);
  inject(Fault::limited_output, "x", Node::amplifier, 30.0);
  drive(60.0, 20.0);
  EXPECT_EQ(amplifier(x).state(), AmpState::enabled);
  EXPECT_EQ(amplifier(y).fault(), node::internal_fault);
  EXPECT_NEAR(axis(x).plant.drive(), 30.0, 0.1);
}

}  // namespace
}  // namespace hystcan::twin::shared_node_test
