// Two axes in one CAN FD frame: what their nodes share, and what each axis has for itself.
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "can/protocol/sdo.h"
#include "tests/support/shows.h"
#include "tests/twin/twin_bench.h"

namespace hystcan::twin::shared_node_test {
namespace {

using can::AmpState;
using std::chrono::milliseconds;

constexpr const char* dbc = R"(
BO_ 513 Command: 16 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ EnableX : 20|1@1+ (1,0) [0|0] "" X
 SG_ ClearX : 21|1@1+ (1,0) [0|0] "" X
 SG_ EnableY : 22|1@1+ (1,0) [0|0] "" X
 SG_ ClearY : 23|1@1+ (1,0) [0|0] "" X
 SG_ SyncCounter : 24|8@1+ (1,0) [0|0] "" X
 SG_ SetX : 32|32@1- (0.001,0) [0|0] "V" X
 SG_ SetY : 64|32@1- (0.001,0) [0|0] "V" X

BO_ 385 Status: 12 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ StateX : 20|2@1+ (1,0) [0|0] "" X
 SG_ StateY : 22|2@1+ (1,0) [0|0] "" X
 SG_ FaultX : 24|8@1+ (1,0) [0|0] "" X
 SG_ FaultY : 32|2@1+ (1,0) [0|0] "" X
 SG_ OutX : 40|16@1- (0.01,0) [0|0] "V" X
 SG_ OutY : 56|16@1- (0.01,0) [0|0] "V" X

BO_ 641 StatusOfY: 12 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ StateY : 22|2@1+ (1,0) [0|0] "" X
 SG_ FaultY : 24|32@1+ (1,0) [0|0] "" X
 SG_ OutY : 56|16@1- (0.01,0) [0|0] "V" X

BO_ 642 StatusOfYWithoutFault: 12 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ StateY : 22|2@1+ (1,0) [0|0] "" X
 SG_ FaultY : 32|1@1- (1,0) [0|0] "" X
 SG_ OutY : 56|16@1- (0.01,0) [0|0] "V" X

BO_ 2147484033 StatusOfYExtended: 12 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ StateY : 22|2@1+ (1,0) [0|0] "" X
 SG_ FaultY : 32|8@1+ (1,0) [0|0] "" X
 SG_ OutY : 56|16@1- (0.01,0) [0|0] "V" X

BO_ 386 Sample: 16 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ BadX : 20|1@1+ (1,0) [0|0] "" X
 SG_ BadY : 21|1@1+ (1,0) [0|0] "" X
 SG_ SyncCounter : 24|8@1+ (1,0) [0|0] "" X
 SG_ PosX : 32|32@1- (0.000001,0) [0|0] "um" X
 SG_ PosY : 64|32@1- (0.000001,0) [0|0] "um" X
)";

can::AxisFrames frames_of(const std::string& axis) {
  const auto map = [](const char* message, std::map<std::string, std::string, std::less<>> signals) {
    return can::MessageMap{.message = message, .signals = std::move(signals), .polynomial = can::Crc::crc16};
  };
  return {
      .command = map("Command", {{"setpoint", "Set" + axis},
                                 {"enable", "Enable" + axis},
                                 {"clear_fault", "Clear" + axis},
                                 {"sync_counter", "SyncCounter"}}),
      .status =
          map("Status", {{"output", "Out" + axis}, {"state", "State" + axis}, {"fault", "Fault" + axis}}),
      .sample = map("Sample",
                    {{"position", "Pos" + axis}, {"sync_counter", "SyncCounter"}, {"status", "Bad" + axis}})};
}

/// Both axes are served by amplifier node 1 and sensor node 2.
Config two_axes() {
  Config config = one_axis();
  config.axes.push_back(config.axes[0]);
  config.axes[0].wire.frames = frames_of("X");
  config.axes[1].wire.frames = frames_of("Y");
  config.axes[1].wire.name = "y";
  return config;
}

constexpr std::size_t x = 0;
constexpr std::size_t y = 1;

class Bench {
 public:
  explicit Bench(const Config& config = two_axes())
      : twin_(config, database_, clock_, [this](auto) { return bus_.attach(); }) {
    for (const std::size_t axis : {x, y}) {
      command_.push_back(*can::find_layout<can::AmpCommand>(database_, config.axes[axis].wire));
      const auto status = can::find_layout<can::AmpStatus>(database_, config.axes[axis].wire);
      status_.push_back(status ? std::optional(can::Decoder(*status)) : std::nullopt);
      sample_.emplace_back(*can::find_layout<can::SensorSample>(database_, config.axes[axis].wire));
    }
    tester_->on_frame([this](const can::Frame& frame, can::Time) {
      ++heard_[frame.id];
      if (frame.id == 0x081) emergency_ = *can::parse_emergency(frame);
      for (const std::size_t axis : {x, y}) {
        if (frame.id == sample_[axis].id()) samples_[axis] = sample_[axis](frame);
        if (status_[axis] && frame.id == status_[axis]->id()) statuses_[axis] = (*status_[axis])(frame);
      }
    });
    twin_.start();
    run(config.heartbeat_period);  // the twin listens
  }

  void start_nodes() {
    tester_->send(can::nmt_frame({can::NmtCommand::start, 0}));
    run(milliseconds(1));
  }
  void run(can::Duration time) { clock_.run_until(clock_.now() + time); }
  void sync() { tester_->send(can::sync_frame(counter_ = can::next_sync_counter(counter_))); }
  void command(std::array<can::AmpCommand, 2> commands) {
    can::Frame frame = command_[x].frame();
    for (const std::size_t axis : {x, y}) {
      commands[axis].sync_counter = counter_;
      ASSERT_TRUE(command_[axis].put(commands[axis], frame));
    }
    protector_.seal(frame);
    tester_->send(frame);
  }
  /// SYNC and command, once a millisecond, and enough time to arrive.
  void drive(std::array<can::AmpCommand, 2> commands, int cycles) {
    for (int i = 0; i < cycles; ++i) {
      sync();
      command(commands);
      run(milliseconds(1));
    }
  }
  void drive(double to_x, double to_y, int cycles = 10) {
    drive({can::AmpCommand{.setpoint = to_x, .enable = true},
           can::AmpCommand{.setpoint = to_y, .enable = true}},
          cycles);
  }
  const Axis& axis(std::size_t index) { return *twin_.axes()[index]; }
  AmplifierChannel& amplifier(std::size_t index) { return twin_.axes()[index]->amplifier; }
  void inject(Fault kind, const std::string& axis, Node node, std::optional<double> value = {}) {
    FaultSpec spec = fault_spec(kind, axis);
    spec.node = node;
    if (value) spec.value = *value;
    twin_.faults().inject(spec);
  }

  can::VirtualClock clock_;
  can::SimBus bus_{clock_, {1'000'000, 5'000'000}};
  can::Database database_ = can::parse_dbc(dbc, "shared.dbc");
  std::unique_ptr<can::Bus> tester_ = bus_.attach();
  Twin twin_;
  std::vector<can::Layout<can::AmpCommand>> command_;
  std::vector<std::optional<can::Decoder<can::AmpStatus>>> status_;
  std::vector<can::Decoder<can::SensorSample>> sample_;
  can::E2eProtector protector_{
      can::protection_of(*database_.find("Command"), two_axes().axes[0].wire.frames->command)};
  std::map<std::uint32_t, int> heard_;
  std::array<std::optional<can::AmpStatus>, 2> statuses_;
  std::array<std::optional<can::SensorSample>, 2> samples_;
  can::Emergency emergency_;
  std::uint8_t counter_ = 0;
};

class SharedNode : public testing::Test, protected Bench {
 protected:
  SharedNode() { start_nodes(); }
};

// ---- what the axes share

TEST(SharedNodes, BootUpOnceAndSendOneHeartbeatEach) {
  Bench bench;
  bench.run(milliseconds(1));
  for (const std::uint32_t id : {0x701u, 0x702u}) EXPECT_EQ(bench.heard_[id], 1) << "boot-up";
  bench.run(milliseconds(200));
  for (const std::uint32_t id : {0x701u, 0x702u}) EXPECT_EQ(bench.heard_[id], 3);
  EXPECT_EQ(bench.twin_.connections().size(), 2u);
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
  sync();
  run(milliseconds(1));
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

TEST(SharedAmplifier, SendsTwoStatusesWhereEachAxisHasItsOwn) {
  Config config = two_axes();
  config.axes[1].wire.frames->status->message = "StatusOfY";
  Bench bench(config);
  bench.start_nodes();
  bench.heard_.clear();
  bench.amplifier(y).begin_internal_fault();
  bench.run(milliseconds(1));
  EXPECT_EQ(bench.heard_[0x181], 0) << "x has not changed";
  EXPECT_EQ(bench.heard_[0x281], 1);
  EXPECT_EQ(bench.statuses_[y]->state, AmpState::fault);
}

// 0x181 in a base frame and in an extended one.
TEST(SharedAmplifier, SendsTwoStatusesWhereTheirIdentifiersDifferInTheirKindAlone) {
  Config config = two_axes();
  config.axes[1].wire.frames->status->message = "StatusOfYExtended";
  Bench bench(config);
  bench.start_nodes();
  std::array<int, 2> heard{};
  bench.tester_->on_frame([&](const can::Frame& frame, can::Time) {
    if (frame.id == 0x181) ++heard.at(frame.extended ? y : x);
  });
  bench.amplifier(y).begin_internal_fault();
  bench.run(milliseconds(1));
  EXPECT_EQ(heard[x], 0) << "x has not changed";
  EXPECT_EQ(heard[y], 1);
}

TEST(SharedAmplifier, SendsAStatusThatHasNoSignalForTheFault) {
  Config config = two_axes();
  config.axes[1].wire.frames->status->message = "StatusOfY";
  config.axes[1].wire.frames->status->signals.erase("fault");
  Bench bench(config);
  bench.start_nodes();
  bench.amplifier(y).begin_internal_fault();
  bench.run(milliseconds(1));
  EXPECT_EQ(bench.statuses_[y]->state, AmpState::fault);
}

// 16 bits of 0.01 V hold 327.67 V. A status with a wrong output would be worse than none.
TEST(SharedAmplifier, SendsNoStatusWhereTheOutputOfAnAxisDoesNotFitItsSignal) {
  for (const std::size_t axis : {x, y}) {
    Config config = two_axes();
    config.axes[axis].axis.plant.amplifier.drive_max = 400.0;
    Bench bench(config);
    bench.start_nodes();
    bench.drive(axis == x ? 327.0 : 20.0, axis == y ? 327.0 : 20.0, 20);
    EXPECT_GT(bench.heard_[0x181], 0);
    bench.drive(axis == x ? 330.0 : 20.0, axis == y ? 330.0 : 20.0, 5);
    bench.heard_.clear();
    bench.drive(axis == x ? 330.0 : 20.0, axis == y ? 330.0 : 20.0, 50);
    EXPECT_EQ(bench.heard_[0x181], 0) << "axis " << axis;
  }
}

/// What the amplifier of y sends in this message after an internal fault.
std::optional<can::AmpStatus> status_of_internal_fault(const char* message) {
  Config config = two_axes();
  config.axes[1].wire.frames->status->message = message;
  Bench bench(config);
  bench.start_nodes();
  bench.amplifier(y).begin_internal_fault();
  bench.run(milliseconds(1));
  return bench.statuses_[y];
}

TEST(SharedAmplifier, ReportsAFaultAsItIsInASignalOf32Bits) {
  EXPECT_EQ(status_of_internal_fault("StatusOfY")->fault, internal_fault);
}

TEST(SharedAmplifier, SendsTheStatusWhereTheSignalOfTheFaultHoldsNoMoreThanZero) {
  const auto status = status_of_internal_fault("StatusOfYWithoutFault");
  EXPECT_EQ(status->state, AmpState::fault);
  EXPECT_EQ(status->fault, 0);
}

TEST(SharedAmplifier, SendsTheStatusOfTheAxesThatHaveOne) {
  Config config = two_axes();
  config.axes[0].wire.frames->status.reset();
  Bench bench(config);
  bench.start_nodes();
  bench.heard_.clear();
  bench.amplifier(x).begin_internal_fault();
  bench.run(milliseconds(1));
  EXPECT_EQ(bench.heard_[0x181], 0);
  bench.amplifier(y).begin_internal_fault();
  bench.run(milliseconds(1));
  EXPECT_EQ(bench.heard_[0x181], 1);
  EXPECT_EQ(bench.statuses_[y]->state, AmpState::fault);
}

TEST(SharedSensor, HasOneClockForAllItsAxes) {
  Config config = two_axes();
  config.axes[1].axis.sample_clock = {.sampling = Sampling::free, .rate_Hz = 1000.0};
  EXPECT_THROW(Bench{config}, std::invalid_argument);
  config.axes[0].axis.sample_clock = config.axes[1].axis.sample_clock;
  Bench bench(config);
  bench.start_nodes();
  bench.sync();
  bench.run(milliseconds(1));
  bench.heard_.clear();
  bench.run(milliseconds(10));
  EXPECT_NEAR(bench.heard_[0x182], 10, 1);
}

TEST(SharedNodes, StayTogetherWhereATwinHasOnlySomeOfTheAxes) {
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

// ---- what each axis has for itself

TEST_F(SharedNode, TripsTheWatchdogOfEachAxisWhereTheCommandStaysAway) {
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
  Bench bench(config);
  bench.start_nodes();
  bench.drive(60.0, 20.0);
  bench.run(milliseconds(40));
  EXPECT_EQ(bench.amplifier(x).state(), AmpState::fault);
  EXPECT_EQ(bench.amplifier(y).state(), AmpState::enabled);
  bench.run(milliseconds(20));
  EXPECT_EQ(bench.amplifier(y).state(), AmpState::fault);
}

TEST_F(SharedNode, AFaultOfOneAxisLeavesTheOther) {
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

TEST_F(SharedNode, AnAxisThatIsNotEnabledLeavesTheOther) {
  drive({can::AmpCommand{.setpoint = 50.0, .enable = true}, can::AmpCommand{}}, 10);
  EXPECT_EQ(amplifier(x).state(), AmpState::enabled);
  EXPECT_EQ(amplifier(y).state(), AmpState::ready);
}

TEST(SharedSensor, HasOtherNoiseForEachAxis) {
  Config config = two_axes();
  for (WiredAxisConfig& axis : config.axes) axis.axis.sensor.noise_um_rms = 0.1;
  Bench bench(config);
  bench.start_nodes();
  bench.sync();
  bench.run(milliseconds(1));
  EXPECT_NE(bench.samples_[x]->position_um, bench.samples_[y]->position_um);
}

// ---- faults

TEST_F(SharedNode, ALostFrameIsLostForBothAxes) {
  inject(Fault::no_reply, "y", Node::sensor);
  heard_.clear();
  drive(60.0, 20.0);
  EXPECT_EQ(heard_[0x182], 0);
  inject(Fault::watchdog_trip, "y", Node::amplifier);
  drive(60.0, 20.0, 30);
  EXPECT_EQ(amplifier(x).fault(), can::amp_fault::command_timeout);
  EXPECT_EQ(amplifier(y).fault(), can::amp_fault::command_timeout);
}

TEST_F(SharedNode, AFaultOfTheNodeIsOneFaultWhicheverAxisNamesIt) {
  inject(Fault::no_reply, "x", Node::sensor);
  inject(Fault::no_reply, "y", Node::sensor);
  EXPECT_EQ(twin_.faults().active().size(), 1u);
  EXPECT_EQ(twin_.faults().remove(Fault::no_reply, "x"), 1u);
  heard_.clear();
  drive(60.0, 20.0);
  EXPECT_EQ(heard_[0x182], 10);
}

TEST_F(SharedNode, AReplyThatIsLateIsLateForBothAxes) {
  inject(Fault::late, "x", Node::sensor, 2.0);
  drive(60.0, 20.0);
  EXPECT_EQ(samples_[x]->sync_counter, counter_ - 2);
  EXPECT_EQ(samples_[y]->sync_counter, counter_ - 2);
}

TEST_F(SharedNode, ANodeThatLosesItsSupplyLosesBothAxesAndBootsUpOnce) {
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

TEST_F(SharedNode, AWrongValueOfOneAxisLeavesThatOfTheOtherInAFrameThatIsAccepted) {
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
  sync();
  run(milliseconds(1));
  EXPECT_NEAR(samples_[x]->position_um, axis(x).plant.position_um() + 8.0, 0.05);
  EXPECT_NEAR(samples_[y]->position_um, axis(y).plant.position_um() - 5.0, 0.05);
  EXPECT_EQ(twin_.faults().remove(Fault::sensor_offset, "x"), 1u);
  sync();
  run(milliseconds(1));
  EXPECT_NEAR(samples_[x]->position_um, axis(x).plant.position_um(), 0.05);
  EXPECT_NEAR(samples_[y]->position_um, axis(y).plant.position_um() - 5.0, 0.05);
}

TEST_F(SharedNode, ReportsAFaultThatItsSignalDoesNotHoldByTheLargestNumberOfTheSignal) {
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
  EXPECT_EQ(amplifier(y).fault(), internal_fault);
  EXPECT_NEAR(axis(x).plant.drive(), 30.0, 0.1);
}

}  // namespace
}  // namespace hystcan::twin::shared_node_test
