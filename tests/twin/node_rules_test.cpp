// The rules of docs/protocol/nodes.md for amplifier and sensor nodes at the edges of their states, in the
// order of that page, observed at the bus.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "can/frame_bits.h"
#include "can/protocol/sdo.h"
#include "tests/support/shows.h"
#include "tests/twin/twin_bench.h"

namespace hystcan::twin::node_rules_test {
namespace {

using can::AmpState;
using can::NmtCommand;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr can::SdoObject object{.index = 0x2001, .subindex = 1};

class NodeRules : public testing::Test, protected TwinBench {
 protected:
  explicit NodeRules(const Config& config = one_axis()) : TwinBench(config) {
    listener_->on_frame([this](const can::Frame& frame, can::Time) { frames_.push_back(frame); });
    frames_.clear();
  }
  node::AmplifierChannel& amplifier() { return twin_.axes().front()->amplifier; }
  node::SensorNode& sensor() { return twin_.axes().front()->sensor.node(); }
  void nmt(NmtCommand command, std::uint8_t node) {
    tester_->send(can::nmt_frame({command, node}));
    run(milliseconds(1));
  }
  void send(const can::AmpCommand& command) {
    tester_->send(*encode_command_(command));
    run(milliseconds(1));
  }
  /// Makes the watchdog trip.
  void trip() {
    start_nodes();
    drive(50.0, 5);
    run(milliseconds(50));
    ASSERT_EQ(status_->fault, can::amp_fault::command_timeout);
    frames_.clear();
  }
  void write_object() {
    tester_->send(can::sdo_request(
        1, {.service = can::SdoService::write, .object = object, .content = {.value = 140, .bytes = 2}}));
    run(milliseconds(1));
    ASSERT_TRUE(amplifier().node().objects().object(object));
  }
  /// Returns the identifiers of the amplifier's frames since the last clear().
  std::vector<std::uint32_t> sent_by_amplifier() const {
    std::vector<std::uint32_t> ids;
    for (const can::Frame& frame : frames_)
      if (frame.id == 0x701 || frame.id == 0x181 || frame.id == 0x081) ids.push_back(frame.id);
    return ids;
  }

  std::unique_ptr<can::Bus> listener_ = bus_.attach();
  std::vector<can::Frame> frames_;
};

// ---- NMT

TEST_F(NodeRules, NmtToNodeZeroReachesEveryNode) {
  nmt(NmtCommand::start, 3);
  EXPECT_EQ(amplifier().state(), AmpState::off);
  EXPECT_EQ(sensor().state(), can::NmtState::pre_operational);
  nmt(NmtCommand::start, 0);
  EXPECT_EQ(amplifier().state(), AmpState::ready);
  EXPECT_EQ(sensor().state(), can::NmtState::operational);
}

TEST_F(NodeRules, AnUnknownNmtCommandChangesNothing) {
  shows("S-097");
  start_nodes();
  drive(50.0, 5);
  frames_.clear();
  for (const int unknown : {0, 3, 127, 131, 255}) nmt(static_cast<NmtCommand>(unknown), 0);
  EXPECT_EQ(amplifier().state(), AmpState::enabled);
  EXPECT_EQ(sensor().state(), can::NmtState::operational);
  EXPECT_TRUE(sent_by_amplifier().empty());
}

TEST_F(NodeRules, ASecondNmtStartKeepsTheCounters) {
  shows("S-099");
  start_nodes();
  sync();
  const can::Frame first = *encode_command_({.setpoint = 10.0, .enable = true, .sync_counter = counter_});
  tester_->send(first);
  run(milliseconds(1));
  start_nodes();
  tester_->send(first);
  run(milliseconds(1));
  EXPECT_EQ(amplifier().node().checker().rejected(can::Rejection::repeated_counter), 1u);
}

TEST_F(NodeRules, ASensorSendsOneSamplePerSync) {
  shows("S-148");
  start_nodes();
  cycle();
  const int before = heard_[0x182];
  tester_->send(can::sync_frame(counter_));
  run(milliseconds(1));
  EXPECT_EQ(heard_[0x182], before);
  cycle();
  EXPECT_EQ(heard_[0x182], before + 1);
}

TEST_F(NodeRules, ARepeatedSyncCountsOnlyForTheStatus) {
  shows("S-114");
  start_nodes();
  drive(50.0, 1);
  const int before = heard_[0x181];
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(heard_[0x181], before) << "after " << i << " SYNCs, each received twice";
    sync();
    tester_->send(can::sync_frame(counter_));
    command(50.0, true);
    run(milliseconds(1));
  }
  EXPECT_EQ(heard_[0x181], before + 1);
  EXPECT_NEAR(output(), 50.0, 1e-3);
}

TEST_F(NodeRules, ABootUpOfTheControllerChangesNothing) {
  shows("S-081");
  start_nodes();
  drive(50.0, 5);
  frames_.clear();
  tester_->send(can::heartbeat_frame(127, can::NmtState::boot_up));
  run(milliseconds(1));
  EXPECT_EQ(amplifier().state(), AmpState::enabled);
  EXPECT_TRUE(sent_by_amplifier().empty());
}

TEST_F(NodeRules, ASensorBootsUpAtResetCommunicationAndCountsFromZero) {
  start_nodes();
  drive(10.0, 5);
  frames_.clear();
  nmt(static_cast<NmtCommand>(130), 2);
  ASSERT_EQ(frames_.size(), 2u) << "the command and the boot-up";
  EXPECT_EQ(frames_.back(), can::heartbeat_frame(2, can::NmtState::boot_up));
  EXPECT_EQ(sensor().state(), can::NmtState::pre_operational);
  start_nodes();
  frames_.clear();
  cycle();
  EXPECT_EQ(frames_.back().id, 0x182u);
  EXPECT_EQ(frames_.back().data[6], 0);
}

TEST_F(NodeRules, AnAmplifierBootsUpAtResetCommunicationAndIsOff) {
  start_nodes();
  drive(50.0, 5);
  frames_.clear();
  nmt(static_cast<NmtCommand>(130), 0);
  EXPECT_EQ(sent_by_amplifier(), (std::vector<std::uint32_t>{0x701})) << "no status after the boot-up";
  EXPECT_EQ(amplifier().state(), AmpState::off);
  EXPECT_NEAR(output(), 0.0, 1e-3);
}

TEST_F(NodeRules, ResetCommunicationKeepsALatchedFaultAndTheObjects) {
  shows("S-098");
  write_object();
  trip();
  nmt(static_cast<NmtCommand>(130), 1);
  EXPECT_EQ(amplifier().state(), AmpState::off);
  EXPECT_TRUE(amplifier().node().objects().object(object));
  start_nodes();
  EXPECT_EQ(status_->state, AmpState::fault);
  EXPECT_EQ(status_->fault, can::amp_fault::command_timeout);
}

TEST_F(NodeRules, ALatchedFaultSurvivesStopAndPreOperational) {
  shows("S-134");
  trip();
  for (const NmtCommand command : {NmtCommand::stop, NmtCommand::enter_pre_operational}) {
    nmt(command, 1);
    EXPECT_EQ(status_->state, AmpState::off);
    EXPECT_EQ(status_->fault, can::amp_fault::command_timeout) << "the flags stay beside State 0";
    start_nodes();
    EXPECT_EQ(status_->state, AmpState::fault);
  }
}

TEST_F(NodeRules, AnAmplifierReportsOnceThatItLeavesOperational) {
  for (const NmtCommand command : {NmtCommand::stop, NmtCommand::enter_pre_operational}) {
    start_nodes();
    frames_.clear();
    nmt(command, 1);
    EXPECT_EQ(sent_by_amplifier(), (std::vector<std::uint32_t>{0x181}));
    EXPECT_EQ(status_->state, AmpState::off);
  }
}

TEST_F(NodeRules, AnAmplifierSendsOnlyTheBootUpAtAResetOfTheNode) {
  shows("S-146");
  start_nodes();
  drive(50.0, 5);
  frames_.clear();
  nmt(NmtCommand::reset_node, 1);
  EXPECT_EQ(sent_by_amplifier(), (std::vector<std::uint32_t>{0x701}));
  EXPECT_NEAR(output(), 0.0, 1e-3);
}

TEST_F(NodeRules, AnAmplifierReportsSwitchingOffAndThenItsRest) {
  shows("S-084");
  start_nodes();
  drive(50.0, 5);
  frames_.clear();
  twin_.shut_down();
  run(milliseconds(1));
  EXPECT_EQ(sent_by_amplifier(), (std::vector<std::uint32_t>{0x181, 0x181}));
  EXPECT_EQ(status_->state, AmpState::off);
  EXPECT_NEAR(status_->output, 0.0, 1e-3);
}

// ---- SYNC

TEST_F(NodeRules, ASyncWithAnotherCounterOrAnotherLengthIsIgnored) {
  shows("S-089");
  start_nodes();
  frames_.clear();
  for (const can::Frame& wrong :
       {can::sync_frame(0), can::sync_frame(241), can::Frame{.id = 0x080, .length = 0},
        can::Frame{.id = 0x080, .length = 2, .data = {1, 1}}})
    tester_->send(wrong);
  run(milliseconds(2));
  EXPECT_EQ(frames_.size(), 4u) << "no sample answers";
  cycle();
  EXPECT_EQ(frames_.back().id, 0x182u);
}

// ---- commands

TEST_F(NodeRules, ACommandBeforeTheFirstSyncIsStale) {
  shows("S-119");
  start_nodes();
  for (const int named : {0, 1, 239, 240, 241, 255}) {
    send({.setpoint = 50.0, .enable = true, .sync_counter = static_cast<std::uint8_t>(named)});
    EXPECT_EQ(amplifier().state(), AmpState::ready) << "it names SYNC " << named;
  }
}

TEST_F(NodeRules, ACommandThatNamesNoSyncBetween1And240IsStale) {
  shows("S-118");
  start_nodes();
  for (int i = 0; i < 241; ++i) {
    sync();
    for (const int named : {0, 241, 248, 255})
      send({.setpoint = 50.0, .enable = true, .sync_counter = static_cast<std::uint8_t>(named)});
    ASSERT_EQ(amplifier().state(), AmpState::ready) << "after SYNC " << int{counter_};
  }
}

Config without_a_watchdog() {
  Config config = one_axis();
  config.axes.front().axis.command_timeout = std::chrono::seconds(10);
  return config;
}

/// Frames sent at these times, in microseconds. A cycle is 1 ms. On the wire, the SYNC takes 0.06 ms and a
/// command 0.12 ms.
class AgeOfACommand : public NodeRules {
 protected:
  AgeOfACommand() : NodeRules(without_a_watchdog()) {
    start_nodes();
    begin_ = clock_.now();
  }
  void sync_at(int time_us, std::uint8_t counter) {
    clock_.run_until(begin_ + microseconds(time_us));
    tester_->send(can::sync_frame(counter));
  }
  bool takes_command_at(int time_us, std::uint8_t named) {
    clock_.run_until(begin_ + microseconds(time_us));
    setpoint_ += 1.0;
    send({.setpoint = setpoint_, .enable = true, .sync_counter = named});
    return amplifier().setpoint() == setpoint_;
  }

 private:
  can::Time begin_;
  double setpoint_ = 10.0;
};

TEST_F(AgeOfACommand, IsAtMostTwoCyclesEvenWithoutSyncs) {
  shows("S-116");
  sync_at(0, 7);
  EXPECT_TRUE(takes_command_at(300, 7));
  sync_at(10'000, 8);
  EXPECT_TRUE(takes_command_at(11'900, 8));
  sync_at(20'000, 9);
  EXPECT_FALSE(takes_command_at(22'000, 9));
  EXPECT_FALSE(takes_command_at(520'000, 9));
  sync_at(520'900, 10);
  EXPECT_TRUE(takes_command_at(521'200, 10));
}

TEST_F(AgeOfACommand, IsTooGreatIfItsSyncWasNeverReceived) {
  sync_at(0, 7);
  sync_at(1000, 9);
  EXPECT_FALSE(takes_command_at(1300, 8)) << "SYNC 8 was lost";
  EXPECT_TRUE(takes_command_at(2300, 9));
  EXPECT_EQ(amplifier().state(), AmpState::enabled);
  send({.setpoint = 0.0, .enable = false, .sync_counter = 8});
  EXPECT_EQ(amplifier().state(), AmpState::ready);
  sync_at(5000, 10);
  run(microseconds(100));
  for (const NmtCommand command : {NmtCommand::reset_node, NmtCommand::start})
    tester_->send(can::nmt_frame({command, 1}));
  sync_at(6000, 11);
  EXPECT_FALSE(takes_command_at(6300, 10)) << "SYNC 10 came before the boot-up";
  EXPECT_TRUE(takes_command_at(7300, 11));
}

TEST_F(AgeOfACommand, IsTwoCyclesToTheNanosecond) {
  shows("S-116");
  const auto witness = bus_.attach();
  std::map<std::uint32_t, can::Time> arrived;
  witness->on_frame([&](const can::Frame& frame, can::Time received) { arrived[frame.id] = received; });
  for (const int late_ns : {0, 1}) {
    sync_at(10'000 * (late_ns + 1), 7);
    run(milliseconds(1));
    const can::Frame frame =
        *encode_command_({.setpoint = 20.0 + late_ns, .enable = true, .sync_counter = 7});
    const can::FrameBits bits = can::frame_bits(frame);
    const can::Time due = arrived[can::sync_id] + milliseconds(2) + std::chrono::nanoseconds(late_ns);
    clock_.run_until(due - can::transmission_time(bits.first(bits.total() - can::interframe_bits), {}));
    tester_->send(frame);
    run(milliseconds(1));
    ASSERT_EQ(arrived[frame.id], due);
    EXPECT_EQ(amplifier().setpoint(), 20.0);
  }
}

TEST_F(AgeOfACommand, CountsFromItsSyncEvenAfterTheNextOne) {
  sync_at(0, 239);
  sync_at(1'500, 240);  // late by half a cycle
  EXPECT_TRUE(takes_command_at(1'800, 239));
  sync_at(10'000, 240);  // a new controller that happens to have this counter
  sync_at(11'500, 1);
  EXPECT_FALSE(takes_command_at(12'000, 240));
  EXPECT_TRUE(takes_command_at(13'300, 1)) << "the late SYNC is its own";
}

TEST_F(AgeOfACommand, CountsFromTheLastCopyOfARepeatedSync) {
  sync_at(0, 7);
  sync_at(1'500, 7);
  EXPECT_TRUE(takes_command_at(3'300, 7));
  EXPECT_FALSE(takes_command_at(4'300, 6)) << "the SYNC before it never came";
}

TEST_F(AgeOfACommand, IsIrrelevantIfItSwitchesOff) {
  shows("S-117");
  sync_at(0, 7);
  EXPECT_TRUE(takes_command_at(300, 7));
  clock_.run_until(clock_.now() + microseconds(9'000));
  send({.setpoint = 0.0, .enable = false, .sync_counter = 7});
  EXPECT_EQ(amplifier().state(), AmpState::ready);
}

TEST_F(NodeRules, AStaleCommandCountsForTheRuleOfTheCounter) {
  shows("S-120");
  start_nodes();
  sync();
  auto same_counter = encode_command_;
  send({.setpoint = 50.0, .enable = true, .sync_counter = 0});
  tester_->send(*same_counter({.setpoint = 50.0, .enable = true, .sync_counter = counter_}));
  run(milliseconds(1));
  EXPECT_EQ(amplifier().node().checker().rejected(can::Rejection::repeated_counter), 1U);
  EXPECT_EQ(amplifier().state(), AmpState::ready);
}

TEST(FramesWithoutASyncCounter, AreNeverStale) {
  Config config = one_axis();
  config.axes.front().wire.frames =
      can::AxisFrames{.command = {.message = "XAmpCommand", .signals = {{"setpoint", "Setpoint"}}},
                      .sample = {.message = "XSensorSample", .signals = {{"position", "Position"}}}};
  TwinBench bench(config);
  bench.start_nodes();
  bench.command(50.0, true);
  bench.run(milliseconds(1));
  EXPECT_EQ(bench.twin_.axes().front()->amplifier.state(), AmpState::enabled) << "before the first SYNC";
}

TEST_F(NodeRules, TheSetpointOfACommandWithoutEnableIsIgnored) {
  shows("S-112");
  start_nodes();
  sync();
  send({.setpoint = 2000.0, .enable = false, .sync_counter = counter_});
  EXPECT_EQ(amplifier().state(), AmpState::ready);
  EXPECT_EQ(amplifier().fault(), 0);
  EXPECT_TRUE(emergencies_.empty());
}

// ---- faults

TEST_F(NodeRules, TheEmergencyIsSentBeforeTheStatusOfAFault) {
  shows("S-132");
  start_nodes();
  drive(50.0, 3);
  frames_.clear();
  run(milliseconds(30));
  EXPECT_EQ(sent_by_amplifier(), (std::vector<std::uint32_t>{0x081, 0x181}));
}

TEST_F(NodeRules, ASecondCauseHasItsEmergencyAtOnceAndItsBitInTheNextStatus) {
  shows("S-135");
  trip();
  amplifier().begin_internal_fault();
  run(milliseconds(1));
  EXPECT_EQ(sent_by_amplifier(), (std::vector<std::uint32_t>{0x081})) << "the state does not change";
  EXPECT_EQ(emergencies_.back(), 0x5000);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(status_->fault, can::amp_fault::command_timeout);
    cycle();
  }
  EXPECT_EQ(status_->fault, can::amp_fault::command_timeout | node::internal_fault);
}

TEST_F(NodeRules, TheErrorRegisterIsZeroOnceTheFaultIsCleared) {
  shows("S-141");
  trip();
  sync();
  send({.clear_fault = true, .sync_counter = counter_});
  ASSERT_EQ(sent_by_amplifier(), (std::vector<std::uint32_t>{0x081, 0x181}));
  const auto cleared =
      std::ranges::find_if(frames_, [](const can::Frame& frame) { return frame.id == 0x081; });
  EXPECT_EQ(*cleared, can::emergency_frame(1, {.code = 0x0000, .error_register = 0x00}));
}

TEST_F(NodeRules, ClearFaultTogetherWithEnableClearsAndDoesNotEnable) {
  shows("S-113");
  trip();
  sync();
  send({.setpoint = 50.0, .enable = true, .clear_fault = true, .sync_counter = counter_});
  EXPECT_EQ(status_->state, AmpState::ready);
  run(milliseconds(30));
  EXPECT_EQ(status_->state, AmpState::ready);
  sync();
  send({.setpoint = 50.0, .enable = true, .sync_counter = counter_});
  EXPECT_EQ(status_->state, AmpState::enabled);
}

TEST_F(NodeRules, ClearFaultWithoutAFaultChangesNothing) {
  shows("S-138");
  start_nodes();
  drive(50.0, 5);
  frames_.clear();
  sync();
  send({.setpoint = 60.0, .enable = true, .clear_fault = true, .sync_counter = counter_});
  EXPECT_EQ(amplifier().state(), AmpState::enabled);
  EXPECT_EQ(amplifier().setpoint(), 60.0);
  EXPECT_TRUE(sent_by_amplifier().empty());
}

TEST_F(NodeRules, ClearFaultWhileTheCausePersistsIsIgnored) {
  shows("S-137");
  start_nodes();
  amplifier().begin_internal_fault();
  run(milliseconds(1));
  frames_.clear();
  sync();
  send({.clear_fault = true, .sync_counter = counter_});
  EXPECT_TRUE(sent_by_amplifier().empty());
  EXPECT_EQ(amplifier().state(), AmpState::fault);
}

TEST_F(NodeRules, TheWatchdogDoesNotTripAReadyAmplifier) {
  shows("S-128");
  start_nodes();
  sync();
  send({.sync_counter = counter_});
  frames_.clear();
  run(milliseconds(90));
  EXPECT_TRUE(sent_by_amplifier().empty());
  EXPECT_EQ(amplifier().state(), AmpState::ready);
}

}  // namespace
}  // namespace hystcan::twin::node_rules_test
