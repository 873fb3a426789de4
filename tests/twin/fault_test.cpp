// The twin's faults observed at the bus: literal frames, start and end times, refusals.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <ostream>
#include <utility>
#include <vector>

#include "can/protocol/protocol.h"
#include "can/sim/sim_bus.h"
#include "tests/support/refusal.h"
#include "tests/twin/twin_bench.h"
#include "twin/twin.h"

namespace hystcan::twin::fault_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
enum class Event { begins, ends };

const can::Database& database() {
  static const can::Database shipped = can::load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  return shipped;
}

FaultSpec spec(Fault kind, can::Duration begins, can::Duration lasts, double value) {
  FaultSpec made = fault_spec(kind, "x");
  made.begins = begins;
  made.lasts = lasts;
  made.value = value;
  return made;
}
FaultSpec spec(Fault kind, can::Duration begins, can::Duration lasts) {
  return spec(kind, begins, lasts, traits(kind).value);
}

// ---- a connection

/// Sample of sync 7 at 12.345678 um, counter 3; the layout is in docs/protocol/frames.md.
can::Frame sample(std::uint8_t counter = 3) {
  can::Frame frame{.id = 0x182, .length = 8};
  frame.data = {0x4E, 0x61, 0xBC, 0x00, 7, 0, counter, 0};
  const std::array<std::uint8_t, 9> covered{0x82, 0x01, 0x4E, 0x61, 0xBC, 0x00, 7, 0, counter};
  frame.data[7] = can::crc8_j1850(covered);
  return frame;
}

/// The sensor's connection, and the frames that arrive at the other end of the wire.
class Connection : public testing::Test {
 protected:
  Connection() {
    far_end_->on_frame([this](const can::Frame& frame, can::Time) { heard_.push_back(frame); });
    connection_.add_channel(sent_by(Node::sensor, database(), one_axis().axes[0].wire));
    connection_.on_frame([this](const can::Frame&, can::Time) { ++obeyed_; });
  }
  const can::Frame& after(const can::Frame& frame) {
    send(frame);
    return heard_.back();
  }
  void send(const can::Frame& frame) {
    connection_.send(frame);
    run(milliseconds(1));
  }
  void run(can::Duration time) { clock_.run_until(clock_.now() + time); }
  std::optional<can::SensorSample> read(const can::Frame& frame) {
    return can::Decoder<can::SensorSample>(*database().find("XSensorSample"))(frame);
  }

  can::VirtualClock clock_;
  can::SimBus bus_{clock_, {1'000'000}};
  std::unique_ptr<can::Bus> far_end_ = bus_.attach();
  FaultyConnection connection_{bus_.attach(), clock_, {.node = 2, .seed = 1}};
  std::vector<can::Frame> heard_;
  int obeyed_ = 0;
};

using FaultyConnectionTest = Connection;

TEST_F(FaultyConnectionTest, PassesEveryFrameUnchangedWithoutAFault) {
  EXPECT_EQ(after(sample()), sample());
  connection_.begin(Fault::wrong_crc, 0.0);
  connection_.end(Fault::wrong_crc);
  EXPECT_EQ(after(sample()), sample());
}

TEST_F(FaultyConnectionTest, FlipsOnlyOneBitOfTheCrc) {
  connection_.begin(Fault::wrong_crc, 0.0);
  can::Frame expected = sample();
  expected.data[7] ^= 0x10;
  EXPECT_EQ(after(sample()), expected);
}

TEST_F(FaultyConnectionTest, FreezesTheValueAndKeepsCounterAndCrcRight) {
  connection_.begin(Fault::frozen_value, 0.0);
  send(sample(3));
  can::Frame next = sample(4);
  next.data[0] = 0x00;
  const auto read_back = read(after(next));
  ASSERT_TRUE(read_back) << "the CRC is right";
  EXPECT_EQ(read_back->position_um, 12.345678);
  EXPECT_EQ(heard_.back().data[6], 4) << "the counter continues";
}

TEST_F(FaultyConnectionTest, FreezesTheCounterAndKeepsTheCrcRight) {
  connection_.begin(Fault::frozen_counter, 0.0);
  send(sample(3));
  EXPECT_EQ(after(sample(4)), sample(3)) << "sample 4 carries the counter of sample 3";
}

TEST_F(FaultyConnectionTest, SendsAnImpossiblePosition) {
  connection_.begin(Fault::out_of_range, 1000.0);
  EXPECT_EQ(read(after(sample()))->position_um, 1000.0);
  connection_.begin(Fault::out_of_range, 1e9);  // beyond the signal's range: sends its largest value
  EXPECT_GT(read(after(sample()))->position_um, 1000.0);
}

TEST_F(FaultyConnectionTest, ShowsAMultipleOfTheMotionSinceTheFaultBegan) {
  connection_.begin(Fault::sensor_gain, -1.0);
  EXPECT_EQ(read(after(sample()))->position_um, 12.345678);
  can::Frame moved = sample(4);
  moved.data[0] += 1;  // 1e-6 um
  EXPECT_NEAR(read(after(moved))->position_um, 12.345677, 1e-9);
  connection_.end(Fault::sensor_gain);
  connection_.begin(Fault::sensor_gain, 0.1);
  EXPECT_NEAR(read(after(moved))->position_um, 12.345679, 1e-9) << "begins where the stage is now";
}

TEST_F(FaultyConnectionTest, AddsAnOffset) {
  connection_.begin(Fault::sensor_offset, -8.0);
  EXPECT_NEAR(read(after(sample()))->position_um, 4.345678, 1e-9);
}

TEST_F(FaultyConnectionTest, SetsABadStatusInTheSample) {
  connection_.begin(Fault::sensor_bad_status, 0.0);
  EXPECT_EQ(read(after(sample()))->status, 1);
}

TEST_F(FaultyConnectionTest, SendsEachSampleInsteadOfALaterOne) {
  connection_.begin(Fault::late, 2.0);
  for (std::uint8_t counter = 1; counter <= 5; ++counter) send(sample(counter));
  ASSERT_EQ(heard_.size(), 3u);
  EXPECT_EQ(heard_.back(), sample(3));
  connection_.end(Fault::late);
  EXPECT_EQ(after(sample(6)), sample(6)) << "held-back frames are dropped";
  EXPECT_EQ(heard_.size(), 4u);
}

TEST_F(FaultyConnectionTest, SendsTheSecondOfTwoSamplesFirst) {
  connection_.begin(Fault::out_of_order, 0.0);
  for (std::uint8_t counter = 1; counter <= 4; ++counter) send(sample(counter));
  EXPECT_EQ(heard_, (std::vector{sample(2), sample(1), sample(4), sample(3)}));
}

TEST_F(FaultyConnectionTest, DoublesLosesAndDistortsSamplesOrHeartbeatsSeparately) {
  const can::Frame heartbeat = can::heartbeat_frame(2, can::NmtState::operational);
  connection_.begin(Fault::duplicate, 0.0);
  send(sample());
  EXPECT_EQ(heard_, (std::vector{sample(), sample()}));
  EXPECT_EQ(after(heartbeat), heartbeat);
  EXPECT_EQ(heard_.size(), 3u);
  connection_.end(Fault::duplicate);
  connection_.begin(Fault::wrong_length, 0.0);
  EXPECT_LT(after(sample()).length, 8);
  connection_.end(Fault::wrong_length);
  connection_.begin(Fault::wrong_id_type, 0.0);
  EXPECT_TRUE(after(sample()).extended);
  connection_.end(Fault::wrong_id_type);
  connection_.begin(Fault::no_reply, 0.0);
  const std::size_t before = heard_.size();
  send(sample());
  EXPECT_EQ(heard_.size(), before);
  EXPECT_EQ(after(heartbeat), heartbeat) << "the heartbeat continues";
  connection_.end(Fault::no_reply);
  connection_.begin(Fault::no_heartbeat, 0.0);
  EXPECT_EQ(after(sample()), sample());
  EXPECT_EQ(after(heartbeat), sample()) << "no heartbeat is sent";
}

TEST_F(FaultyConnectionTest, NeitherSendsNorReceivesInBusOff) {
  connection_.begin(Fault::bus_off, 0.0);
  send(sample());
  far_end_->send(can::sync_frame(1));
  run(milliseconds(1));
  EXPECT_TRUE(heard_.empty());
  EXPECT_EQ(obeyed_, 0);
  connection_.end(Fault::bus_off);
  far_end_->send(can::sync_frame(2));
  run(milliseconds(1));
  EXPECT_EQ(obeyed_, 1);
}

TEST_F(FaultyConnectionTest, LosesTheGivenShareOfFramesWhileErrorPassive) {
  connection_.begin(Fault::error_passive, 0.3);
  constexpr int frames = 1000;
  for (int i = 0; i < frames; ++i) {
    far_end_->send(can::sync_frame(1));
    run(milliseconds(1));
  }
  // Binomial: 300 missed frames, standard deviation 14.5; the tolerance is five standard deviations.
  EXPECT_NEAR(frames - obeyed_, 300, 73);
}

TEST_F(FaultyConnectionTest, BabblesAtItsRateWithTheMostUrgentUnusedIdentifier) {
  connection_.begin(Fault::babbling_node, 2000.0);
  run(milliseconds(100));
  ASSERT_NEAR(static_cast<double>(heard_.size()), 200.0, 1.0);
  EXPECT_EQ(heard_.back().id, 0x001u);
  connection_.end(Fault::babbling_node);
  run(milliseconds(1));
  const std::size_t so_far = heard_.size();
  run(milliseconds(100));
  EXPECT_EQ(heard_.size(), so_far);
}

TEST_F(FaultyConnectionTest, SendsAnEmergencyAndItsEnd) {
  connection_.begin(Fault::emergency, 0x4210);
  connection_.end(Fault::emergency);
  run(milliseconds(1));
  ASSERT_EQ(heard_.size(), 2u);
  EXPECT_EQ(heard_[0], can::emergency_frame(2, {.code = 0x4210, .error_register = 1}));
  EXPECT_EQ(can::parse_emergency(heard_[1])->code, 0);
}

// ---- a schedule

struct ReportedEvent {
  Fault kind;
  Event event;
  can::Duration when;
  friend bool operator==(const ReportedEvent&, const ReportedEvent&) = default;
};
std::ostream& operator<<(std::ostream& out, const ReportedEvent& reported) {
  return out << to_string(reported.kind) << (reported.event == Event::begins ? " begins " : " ends ")
             << can::seconds(reported.when);
}

struct TwinRun {
  explicit TwinRun(Config config)
      : twin(std::move(config), database(), clock, [this](auto) { return bus.attach(); }) {
    twin.faults().on_event([this](const FaultSpec& of, bool begins, can::Time when) {
      reported.push_back({of.kind, begins ? Event::begins : Event::ends, when.time_since_epoch()});
    });
    twin.start();
  }
  void run_for(can::Duration time) { clock.run_until(clock.now() + time); }

  can::VirtualClock clock;
  can::SimBus bus{clock, {1'000'000}};
  std::unique_ptr<can::Bus> other_node = bus.attach();
  Twin twin;
  std::vector<ReportedEvent> reported;
};

TEST(FaultSchedule, BeginsAndEndsFaultsAtTheirTimes) {
  Config config = one_axis();
  config.faults = {spec(Fault::wrong_crc, milliseconds(500), milliseconds(250)),
                   spec(Fault::load_step, milliseconds(300), milliseconds(100))};
  config.faults[1].repeat_every = milliseconds(400);
  TwinRun run(config);
  run.run_for(seconds(1));
  const std::vector<ReportedEvent> expected{{Fault::load_step, Event::begins, milliseconds(300)},
                                            {Fault::load_step, Event::ends, milliseconds(400)},
                                            {Fault::wrong_crc, Event::begins, milliseconds(500)},
                                            {Fault::load_step, Event::begins, milliseconds(700)},
                                            {Fault::wrong_crc, Event::ends, milliseconds(750)},
                                            {Fault::load_step, Event::ends, milliseconds(800)}};
  EXPECT_EQ(run.reported, expected);
}

TEST(FaultSchedule, CountsFromTheStartAndInjectsNothingBeforeTheNodesBoot) {
  Config config = one_axis();
  config.faults = {spec(Fault::babbling_node, can::Duration{0}, seconds(1))};
  TwinRun run(config);
  run.run_for(milliseconds(99));
  EXPECT_TRUE(run.reported.empty()) << "the twin first listens for nodes with the same numbers";
  run.run_for(milliseconds(2));
  EXPECT_EQ(run.reported.size(), 1u);
}

TEST(FaultSchedule, DriftsLinearlyAndStaysThere) {
  Config config = one_axis();
  config.faults = {spec(Fault::parameter_drift, seconds(1), seconds(2), -0.1)};
  TwinRun run(config);
  Plant& plant = run.twin.axes()[0]->plant;
  const auto position_at = [&](can::Duration time) {
    run.clock.run_until(can::Time{time});
    plant.advance_to(run.clock.now());
    return plant.position_um();
  };
  const double rest_um = position_at(milliseconds(200));  // booted and without a command
  plant.set_target(80.0);
  const double before_um = position_at(milliseconds(900)) - rest_um;
  ASSERT_GT(before_um, 10.0);
  // The staircase of 1 ms is late by half a step on average; the ringing of the mode is smaller.
  EXPECT_NEAR(position_at(seconds(2)) - rest_um, 0.95 * before_um, 1e-4 * before_um);
  EXPECT_NEAR(position_at(seconds(4)) - rest_um, 0.9 * before_um, 1e-6 * before_um);
  EXPECT_TRUE(run.twin.faults().active().empty());
  EXPECT_EQ(run.twin.faults().remove(), 0u) << "no fault is active";
  EXPECT_NEAR(position_at(seconds(5)) - rest_um, before_um, 1e-6 * before_um) << "the drift is taken back";
}

TEST(FaultSchedule, DisplacesTheStageWhileALoadLasts) {
  Config config = one_axis();
  config.faults = {spec(Fault::load_step, seconds(1), seconds(1), 2.5)};
  TwinRun run(config);
  Plant& plant = run.twin.axes()[0]->plant;
  std::vector<double> positions_um;
  for (const auto time : {milliseconds(900), milliseconds(1900), milliseconds(2900)}) {
    run.clock.run_until(can::Time{time});
    plant.advance_to(run.clock.now());
    positions_um.push_back(plant.position_um());
  }
  EXPECT_NEAR(positions_um[1] - positions_um[0], 2.5, 1e-9);
  EXPECT_NEAR(positions_um[2] - positions_um[0], 0.0, 1e-9);
}

TEST(FaultSchedule, RandomFaultsAreTheSameFromTheSameSeedAndHaveTheirRate) {
  const auto drawn = [](std::uint64_t seed) {
    Config config = one_axis();
    config.random_faults = RandomFaults{.seed = seed, .rate_per_hour = 3600.0};
    TwinRun run(config);
    run.run_for(seconds(400));
    return run.reported;
  };
  const std::vector<ReportedEvent> once = drawn(3);
  EXPECT_EQ(once, drawn(3));
  EXPECT_NE(once, drawn(4));
  const auto begun = std::ranges::count(once, Event::begins, &ReportedEvent::event);
  EXPECT_NEAR(static_cast<double>(begun), 400.0, 100.0) << "Poisson: standard deviation 20; five of these";
  for (std::size_t i = 0; i < fault_count; ++i)
    EXPECT_NE(std::ranges::find(once, static_cast<Fault>(i), &ReportedEvent::kind), once.end())
        << to_string(static_cast<Fault>(i));
}

TEST(FaultSchedule, RandomFaultsAreOnlyOfTheConfiguredKinds) {
  Config config = one_axis();
  config.random_faults = RandomFaults{.rate_per_hour = 3600.0, .kinds = {Fault::late, Fault::load_step}};
  TwinRun run(config);
  run.run_for(seconds(60));
  ASSERT_FALSE(run.reported.empty());
  for (const ReportedEvent& one : run.reported)
    EXPECT_TRUE(one.kind == Fault::late || one.kind == Fault::load_step);
}

TEST(FaultAtRunTime, BeginsNowCanBeReplacedAndCanBeRemoved) {
  TwinRun run(one_axis());
  run.run_for(milliseconds(200));
  FaultScheduler& faults = run.twin.faults();
  faults.inject(spec(Fault::no_reply, {}, {}));
  faults.inject(spec(Fault::late, {}, milliseconds(100), 2.0));
  faults.inject(spec(Fault::late, {}, milliseconds(300), 3.0));
  ASSERT_EQ(faults.active().size(), 2u) << "the second one replaces the first one";
  run.run_for(milliseconds(200));
  EXPECT_EQ(faults.active().size(), 2u);
  run.run_for(milliseconds(101));
  ASSERT_EQ(faults.active().size(), 1u);
  run.run_for(seconds(60));
  EXPECT_EQ(faults.active().size(), 1u) << "it lasts until it is removed";
  EXPECT_EQ(faults.remove(Fault::late), 0u);
  EXPECT_EQ(faults.remove(Fault::no_reply, "y"), 0u);
  EXPECT_EQ(faults.remove(Fault::no_reply, "x"), 1u);
  EXPECT_TRUE(faults.active().empty());
}

TEST(FaultAtRunTime, IsRefusedWithTheReasonIfImpossible) {
  TwinRun run(one_axis());
  const auto refusal_of = [&](const FaultSpec& asked) -> std::string {
    return support::refusal_of<std::invalid_argument>([&] { run.twin.faults().inject(asked); });
  };
  FaultSpec other_axis = spec(Fault::late, {}, seconds(1));
  other_axis.axis = "z";
  EXPECT_EQ(refusal_of(other_axis), "there is no axis \"z\", expected an axis of this twin");
  FaultSpec wrong_node = spec(Fault::sensor_bad_status, {}, seconds(1));
  wrong_node.node = Node::amplifier;
  EXPECT_EQ(refusal_of(wrong_node), "sensor_bad_status is a fault of the sensor, expected node = \"sensor\"");
  EXPECT_EQ(refusal_of(spec(Fault::late, {}, seconds(1), 17.0)),
            "late: value is 17 cycles, expected 1 to 16");
  EXPECT_EQ(refusal_of(spec(Fault::late, {}, seconds(1), 1.5)),
            "late: value is 1.5, expected a whole number");
  EXPECT_EQ(refusal_of(spec(Fault::parameter_drift, {}, {})),
            "parameter_drift: the duration is 0 s, expected a duration above 0 s");
  EXPECT_TRUE(run.twin.faults().active().empty());
}

TEST(FaultAtRunTime, IsRefusedIfTheFramesHaveNoSuchField) {
  can::AxisWire wire = one_axis().axes[0].wire;
  can::MessageMap plain{.message = "LabSample", .signals = {{"position", "Pos"}}};
  plain.integrity = can::Integrity::none;
  wire.frames.emplace(can::AxisFrames{.command = {.message = "LabCommand"}, .sample = plain});
  EXPECT_EQ(reason_against(spec(Fault::frozen_counter, {}, seconds(1)), wire),
            "frozen_counter: message LabSample has no counter, expected a message with this signal");
  EXPECT_EQ(reason_against(spec(Fault::wrong_crc, {}, seconds(1)), wire),
            "wrong_crc: message LabSample has no CRC, expected a message with this signal");
  EXPECT_EQ(reason_against(spec(Fault::sensor_bad_status, {}, seconds(1)), wire),
            "sensor_bad_status: message LabSample has no status, expected a message with this signal");
  EXPECT_EQ(reason_against(spec(Fault::frozen_value, {}, seconds(1)), wire), std::nullopt);
  FaultSpec of_status = spec(Fault::frozen_value, {}, seconds(1));
  of_status.node = Node::amplifier;
  EXPECT_EQ(reason_against(of_status, wire),
            "frozen_value: the amplifier sends no status, expected an amplifier with a status message");
}

TEST(FaultNames, AreParsedBackToTheirKind) {
  for (std::size_t i = 0; i < fault_count; ++i) {
    const auto kind = static_cast<Fault>(i);
    EXPECT_EQ(parse_word<Fault>(to_string(kind)), kind);
  }
  EXPECT_FALSE(parse_word<Fault>("no_such"));
}

}  // namespace
}  // namespace hystcan::twin::fault_test
