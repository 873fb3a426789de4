// The simulated bus with errors: error frames, fault confinement, bus-off (ISO 11898-1).
#include <gtest/gtest.h>

#include <vector>

#include "can/sim/sim_bus.h"
#include "can/sim/sim_node.h"

namespace hystcan::can::sim_bus_fault_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t bitrate = 1'000'000;
constexpr Duration bit = 1us;
constexpr unsigned error_at_once_bits = 1 + 6 + 8 + 3;  ///< erroneous bit, flags, delimiter, interframe space

Time at(Duration since_start) { return Time{since_start}; }

Frame frame_of(std::uint32_t id, std::uint8_t length = 8) { return Frame{.id = id, .length = length}; }
Duration time_of(const Frame& frame) { return frame_bits(frame).total() * bit; }

struct Heard {
  std::uint32_t id;
  Time received;
  friend bool operator==(const Heard&, const Heard&) = default;
};

struct Listener {
  explicit Listener(SimBus& wire) : bus(wire.attach()) {
    bus->on_frame([this](const Frame& frame, Time received) { heard.push_back({frame.id, received}); });
    bus->on_state([this](BusState state) { states.push_back(state); });
  }
  std::unique_ptr<SimNode> bus;
  std::vector<Heard> heard;
  std::vector<BusState> states;
};

struct SimBusFaults : testing::Test {
  VirtualClock clock;
  SimBus wire{clock, {bitrate}};

  void run_for(Duration duration) { clock.run_until(clock.now() + duration); }
};

TEST(FaultConfinement, FollowsTheRulesOfTheStandard) {
  sim::FaultConfinement node;
  for (int i = 0; i < 12; ++i) node.transmit_error();
  EXPECT_EQ(node.counters(), (ErrorCounters{96, 0}));
  EXPECT_EQ(node.state(), BusState::warning);
  node.transmitted();
  EXPECT_EQ(node.counters(), (ErrorCounters{95, 0}));
  EXPECT_EQ(node.state(), BusState::active);
  for (int i = 0; i < 5; ++i) node.not_acknowledged();
  EXPECT_EQ(node.counters(), (ErrorCounters{135, 0})) << "127 is still error-active, 135 is error-passive";
  node.not_acknowledged();
  EXPECT_EQ(node.counters(), (ErrorCounters{135, 0}));
  EXPECT_EQ(node.state(), BusState::passive);
  for (int i = 0; i < 15; ++i) node.transmit_error();
  EXPECT_EQ(node.counters().transmit, 255);
  EXPECT_EQ(node.state(), BusState::passive);
  node.transmit_error();
  EXPECT_EQ(node.state(), BusState::bus_off);
  node.restart();
  EXPECT_EQ(node.counters(), (ErrorCounters{0, 0}));
}

TEST(FaultConfinement, MakesAPassiveReceiverActiveAfterAReceivedFrame) {
  sim::FaultConfinement node;
  node.received();
  EXPECT_EQ(node.counters().receive, 0);
  for (int i = 0; i < 15; ++i) {
    node.receive_error();
    node.dominant_after_error_flag();
  }
  EXPECT_EQ(node.counters().receive, 135);
  EXPECT_EQ(node.state(), BusState::passive);
  node.received();
  EXPECT_GE(node.counters().receive, 119);
  EXPECT_LE(node.counters().receive, 127);
  const auto after = node.counters().receive;
  node.received();
  EXPECT_EQ(node.counters().receive, after - 1);
}

TEST_F(SimBusFaults, MakeALoneTransmitterErrorPassiveButNotBusOff) {
  Listener lone(wire);
  lone.bus->send(frame_of(0x100));
  // The frame up to the ACK slot, then flag, delimiter and interframe space.
  const Duration attempt = time_of(frame_of(0x100)) + (-3 - 8 + 6 + 8 + 3) * bit;
  clock.run_until(at(attempt) - 3 * bit - 1ns);
  EXPECT_EQ(lone.bus->counters().not_acknowledged, 0U);
  clock.run_until(at(attempt));
  EXPECT_EQ(lone.bus->counters().not_acknowledged, 1U);
  EXPECT_EQ(lone.bus->error_counters(), (ErrorCounters{8, 0}));
  clock.run_until(at(100ms));
  EXPECT_EQ(lone.bus->error_counters(), (ErrorCounters{128, 0}))
      << "the counter of a passive node does not rise";
  EXPECT_EQ(lone.states, (std::vector{BusState::warning, BusState::passive}));
  EXPECT_EQ(lone.bus->state(), BusState::passive);
  EXPECT_EQ(lone.bus->counters().warnings, 1U);
  EXPECT_EQ(lone.bus->counters().passives, 1U);
  const auto attempts = lone.bus->counters().not_acknowledged;
  EXPECT_EQ(attempts, 16U + static_cast<unsigned>((100ms - 16 * attempt) / (attempt + 8 * bit)))
      << "a passive node pauses for eight more bits";
  EXPECT_EQ(lone.bus->counters().error_frames, attempts + 2);

  Listener other(wire);
  run_for(1ms);
  ASSERT_EQ(other.heard.size(), 1U) << "the frame is still in the controller";
  EXPECT_EQ(lone.bus->error_counters(), (ErrorCounters{127, 0}));
  EXPECT_EQ(lone.bus->state(), BusState::warning);
}

/// The frame begins, and each bit is wrong from its data phase on: 18 bits at 1 us are after BRS.
TEST(SimBusWithDataPhase, EndsItAtAnErrorAndSendsTheErrorFrameAtTheNominalBitRate) {
  VirtualClock clock;
  SimBus wire(clock, {.nominal_bit_per_s = 1'000'000, .data_bit_per_s = 5'000'000},
              {.bit_error = 1e-2, .seed = 3, .restart_after = {}});
  Listener a(wire), b(wire);
  Frame frame{.id = 0x2AA, .kind = FrameKind::fd, .length = 64, .fd_flags = fd_bit_rate_switch};
  frame.data.fill(0x55);
  a.bus->send(frame);
  std::vector<Time> destroyed;
  std::uint64_t errors = 0;
  for (Time now{}; b.heard.empty() && now < at(100ms); now += 100ns) {
    clock.run_until(now);
    if (std::exchange(errors, a.bus->counters().protocol_errors) != errors) destroyed.push_back(now);
  }
  ASSERT_GE(destroyed.size(), 3U) << "a frame of 575 bits rarely passes";
  const Duration whole = transmission_time(frame_bits(frame).all(), {1'000'000, 5'000'000});
  Time begin{};
  for (const Time end : destroyed) {
    const Duration lasted = end - begin - (6 + 8) * bit;  // flag and delimiter of the error frame
    EXPECT_GT(lasted, Duration::zero());
    EXPECT_LT(lasted, whole);
    const Duration in_phase = lasted - 17 * bit;
    if (in_phase > Duration::zero() && in_phase < 550 * bit / 5) {
      EXPECT_EQ(in_phase % 200ns, 0ns);
    }
    begin = end + 3 * bit;
  }
}

TEST_F(SimBusFaults, ShowInTheFdFramesOfAnErrorPassiveNode) {
  Listener lone(wire);
  Frame frame{.id = 0x100, .kind = FrameKind::fd, .length = 12};
  lone.bus->send(frame);
  run_for(100ms);
  ASSERT_EQ(lone.bus->state(), BusState::passive);
  const auto other = wire.attach();
  std::vector<std::uint8_t> flags;
  other->on_frame([&](const Frame& heard, Time) { flags.push_back(heard.fd_flags); });
  run_for(1ms);
  EXPECT_EQ(flags, (std::vector<std::uint8_t>{fd_error_state}));
}

TEST_F(SimBusFaults, CountInTheFramesThatNoFilterPasses) {
  const std::array filters{Filter{0x200}};
  const auto ear = wire.attach(TransmitOrder::as_sent, filters);
  const auto sender = wire.attach();
  ear->set_faults({.transmit_bit_error = 0.0, .receive_bit_error = 1.0, .overrun = 0.0});
  sender->send(frame_of(0x100));
  run_for(1us);
  ear->set_faults({});
  run_for(1ms);
  EXPECT_EQ(ear->error_counters(), (ErrorCounters{0, 8})) << "9 for the error, and 1 less for the repetition";
  for (int i = 0; i < 8; ++i) sender->send(frame_of(0x100));
  run_for(10ms);
  EXPECT_EQ(ear->error_counters(), (ErrorCounters{0, 0}));
  EXPECT_EQ(ear->counters().received, 0U);
}

TEST_F(SimBusFaults, MakeTheSenderRepeatTheFrameAfterTheErrorFrame) {
  Listener a(wire), b(wire), c(wire);
  wire.set_bit_error(1.0);
  a.bus->send(frame_of(0x100));
  clock.run_until(at(5us));
  wire.set_bit_error(0.0);
  clock.run_until(at(error_at_once_bits * bit));
  EXPECT_EQ(a.bus->error_counters(), (ErrorCounters{8, 0}));
  EXPECT_EQ(b.bus->error_counters(), (ErrorCounters{0, 1}));
  clock.run_until(at(10ms));
  const Time due = at(error_at_once_bits * bit + time_of(frame_of(0x100)) - interframe_bits * bit);
  EXPECT_EQ(b.heard, (std::vector<Heard>{{0x100, due}}));
  EXPECT_EQ(c.heard, b.heard);
  EXPECT_EQ(a.bus->error_counters(), (ErrorCounters{7, 0}));
  EXPECT_EQ(b.bus->error_counters(), (ErrorCounters{0, 0}));
  for (const Listener* node : {&a, &b, &c}) {
    EXPECT_EQ(node->bus->counters().protocol_errors, 1U);
    EXPECT_EQ(node->bus->counters().error_frames, 1U);
    EXPECT_TRUE(node->states.empty());
  }
}

TEST_F(SimBusFaults, MakeTheDestroyedFrameArbitrateAgain) {
  Listener a(wire), b(wire), ear(wire);
  wire.set_bit_error(1.0);
  a.bus->send(frame_of(0x300));
  a.bus->send(frame_of(0x100));
  clock.run_until(at(5us));
  wire.set_bit_error(0.0);
  b.bus->send(frame_of(0x200));
  clock.run_until(at(10ms));
  ASSERT_EQ(ear.heard.size(), 3U);
  EXPECT_EQ(ear.heard[0].id, 0x200U);
  EXPECT_EQ(ear.heard[1].id, 0x300U) << "it comes before a later frame of its node";
  EXPECT_EQ(ear.heard[2].id, 0x100U);
  EXPECT_EQ(a.bus->counters().arbitration_lost, 1U);
}

/// Drives `node` to bus-off by errors visible to all nodes. Returns the time of bus-off.
Time force_off(VirtualClock& clock, SimBus& wire, Listener& node) {
  wire.set_bit_error(1.0);
  node.bus->send(frame_of(0x100));
  while (node.bus->state() != BusState::bus_off) clock.run_until(clock.now() + bit);
  wire.set_bit_error(0.0);
  return clock.now();
}

TEST_F(SimBusFaults, MakeATransmitterBusOffAfter32ErrorsAndItsQueueIsLost) {
  Listener a(wire), b(wire);
  a.bus->send(frame_of(0x101));
  const Time off = force_off(clock, wire, a);
  // The first 16 attempts follow at once, each of the other 16 after the pause of a passive node.
  EXPECT_EQ(off, at((32 * error_at_once_bits + 16 * 8 - 3) * bit));
  EXPECT_EQ(a.states, (std::vector{BusState::warning, BusState::passive, BusState::bus_off}));
  EXPECT_EQ(a.bus->error_counters(), (ErrorCounters{256, 0}));
  EXPECT_EQ(a.bus->counters().bus_offs, 1U);
  EXPECT_EQ(b.bus->error_counters(), (ErrorCounters{0, 32}));
  EXPECT_EQ(b.bus->state(), BusState::active);
  EXPECT_FALSE(a.bus->send(frame_of(0x102)));
  EXPECT_EQ(a.bus->counters().send_refused, 1U);
  b.bus->send(frame_of(0x200));
  run_for(1s);
  EXPECT_TRUE(a.heard.empty()) << "a bus-off node receives nothing";
  EXPECT_TRUE(b.heard.empty());
  EXPECT_EQ(a.bus->state(), BusState::bus_off) << "there is no automatic restart";
  EXPECT_GT(b.bus->counters().not_acknowledged, 0U) << "a bus-off node acknowledges nothing";
}

TEST_F(SimBusFaults, EndBusOffOnRequestAfter128Times11RecessiveBits) {
  Listener a(wire), b(wire);
  force_off(clock, wire, a);
  run_for(1ms);
  a.bus->restart();
  const Time back = clock.now() + 128 * 11 * bit;
  clock.run_until(back - 1ns);
  EXPECT_EQ(a.bus->state(), BusState::bus_off);
  clock.run_until(back);
  EXPECT_EQ(a.bus->state(), BusState::active);
  EXPECT_EQ(a.states.back(), BusState::active);
  EXPECT_EQ(a.bus->error_counters(), (ErrorCounters{0, 0}));
  EXPECT_EQ(a.bus->counters().restarts, 1U);
  a.bus->send(frame_of(0x103));
  run_for(10ms);
  ASSERT_EQ(b.heard.size(), 1U) << "there is no stale frame";
  EXPECT_EQ(b.heard[0].id, 0x103U);
}

TEST_F(SimBusFaults, EndBusOffLaterWhileTheBusHasTraffic) {
  Listener a(wire), b(wire), c(wire);
  force_off(clock, wire, a);
  run_for(1ms);
  a.bus->restart();
  const Time asked = clock.now();
  // Ten frames follow each other; each counts as one sequence at its end. The other 118 sequences follow in
  // the silence.
  for (int i = 0; i < 8; ++i) b.bus->send(frame_of(0x200));
  for (int i = 0; i < 2; ++i) c.bus->send(frame_of(0x201));
  const Time back = asked + 8 * time_of(frame_of(0x200)) + 2 * time_of(frame_of(0x201)) + 118 * 11 * bit;
  clock.run_until(back - 1ns);
  EXPECT_EQ(a.bus->state(), BusState::bus_off);
  clock.run_until(back);
  EXPECT_EQ(a.bus->state(), BusState::active);
  EXPECT_TRUE(a.heard.empty());
}

TEST(SimBusRestart, IsAutomaticIfItIsConfigured) {
  VirtualClock clock;
  SimBus wire(clock, {bitrate}, {.bit_error = 0.0, .seed = 1, .restart_after = 100ms});
  Listener a(wire), b(wire);
  const Time off = force_off(clock, wire, a);
  clock.run_until(off + 100ms + 128 * 11 * bit - 1ns);
  EXPECT_EQ(a.bus->state(), BusState::bus_off);
  clock.run_until(off + 100ms + 128 * 11 * bit);
  EXPECT_EQ(a.bus->state(), BusState::active);
}

TEST_F(SimBusFaults, MakeOnlyABrokenTransmitterBusOff) {
  Listener broken(wire), b(wire), c(wire);
  broken.bus->set_faults({.transmit_bit_error = 1.0, .receive_bit_error = 0.0, .overrun = 0.0});
  broken.bus->send(frame_of(0x001));
  b.bus->send(frame_of(0x200));
  clock.run_until(at(10ms));
  EXPECT_EQ(broken.bus->state(), BusState::bus_off);
  EXPECT_EQ(b.bus->state(), BusState::active);
  ASSERT_EQ(c.heard.size(), 1U);
  EXPECT_EQ(c.heard[0].id, 0x200U);
}

TEST_F(SimBusFaults, MakeOnlyABrokenReceiverPassive) {
  Listener a(wire), deaf(wire), c(wire);
  deaf.bus->set_faults({.transmit_bit_error = 0.0, .receive_bit_error = 1.0, .overrun = 0.0});
  a.bus->send(frame_of(0x100));
  clock.run_until(at(10ms));
  // Each error adds 1 + 8 to its counter: after 15 errors it is passive and destroys no more frames.
  EXPECT_EQ(deaf.bus->state(), BusState::passive);
  EXPECT_EQ(deaf.bus->error_counters(), (ErrorCounters{0, 15 * 9 + 1}));
  EXPECT_EQ(a.bus->error_counters(), (ErrorCounters{15 * 8 - 1, 0}));
  EXPECT_EQ(c.bus->error_counters(), (ErrorCounters{0, 14}));
  EXPECT_EQ(c.heard.size(), 1U);
  EXPECT_TRUE(deaf.heard.empty());
  EXPECT_EQ(deaf.bus->counters().protocol_errors, 16U);
}

TEST_F(SimBusFaults, CountAnOverrunThatLosesAFrameForOneNode) {
  Listener a(wire), slow(wire), c(wire);
  slow.bus->set_faults({.transmit_bit_error = 0.0, .receive_bit_error = 0.0, .overrun = 1.0});
  a.bus->send(frame_of(0x100));
  clock.run_until(at(10ms));
  EXPECT_TRUE(slow.heard.empty());
  EXPECT_EQ(slow.bus->counters().controller_overflows, 1U);
  EXPECT_EQ(slow.bus->counters().received, 0U);
  EXPECT_EQ(c.heard.size(), 1U);
  EXPECT_EQ(a.bus->counters().not_acknowledged, 0U);
  EXPECT_EQ(wire.attach()->error_counters(), (ErrorCounters{0, 0}));
}

TEST_F(SimBusFaults, MakeAnErrorPassiveTransmitterPauseForOtherNodes) {
  Listener a(wire), b(wire), ear(wire);
  a.bus->set_faults({.transmit_bit_error = 1.0, .receive_bit_error = 0.0, .overrun = 0.0});
  a.bus->send(frame_of(0x100));
  while (a.bus->state() != BusState::passive) run_for(bit);
  a.bus->set_faults({});
  a.bus->send(frame_of(0x101));
  run_for(3 * bit + 7 * bit);  // interframe space, and seven of the eight bits
  b.bus->send(frame_of(0x300));
  run_for(10ms);
  ASSERT_EQ(ear.heard.size(), 3U);
  EXPECT_EQ(ear.heard[0].id, 0x300U);
  EXPECT_EQ(ear.heard[1].id, 0x100U);
  EXPECT_EQ(ear.heard[2].received - ear.heard[1].received, time_of(frame_of(0x101)))
      << "a counter of 127 is error-active: there is no pause";
}

/// Three nodes send 1000 frames in total. With 130 bits and a probability of 2e-4 per bit, 2.6 % of the
/// frames have an error.
std::vector<Heard> noisy_run(std::uint64_t seed, double* load = nullptr) {
  VirtualClock clock;
  SimBus wire(clock, {500'000}, {.bit_error = 2e-4, .seed = seed, .restart_after = {}});
  Listener ear(wire);
  std::vector<std::unique_ptr<Listener>> nodes;
  for (int i = 0; i < 3; ++i) nodes.push_back(std::make_unique<Listener>(wire));
  for (std::uint32_t n = 0; n < 1000; ++n) {
    nodes[n % 3]->bus->send(frame_of(0x100 + n % 3));
    clock.run_until(clock.now() + 700us);
  }
  clock.run_until(clock.now() + 10ms);
  if (load != nullptr) *load = wire.load();
  EXPECT_GT(ear.bus->counters().protocol_errors, 10U);
  return ear.heard;
}

TEST(SimBusNoise, LosesNoFrameAndRepeatsItsResultsForTheSameSeed) {
  const auto run = noisy_run(7);
  EXPECT_EQ(run.size(), 1000U) << "CAN repeats a frame until all nodes have received it";
  EXPECT_EQ(run, noisy_run(7));
  EXPECT_NE(run, noisy_run(8));
}

TEST(SimBusNoise, IncreasesTheLoadByErrorFramesAndRepetitions) {
  double noisy = 0.0;
  noisy_run(7, &noisy);
  const double quiet = 1000 * seconds(time_of(frame_of(0x101))) * 2 / (1000 * 700e-6 + 10e-3);
  EXPECT_GT(noisy, quiet * 1.005);
  EXPECT_LT(noisy, quiet * 1.05) << "2.6 % more frames, most of them incomplete";
}

TEST(SimBusConfiguration, RefusesAProbabilityOutsideZeroToOne) {
  VirtualClock clock;
  EXPECT_THROW(SimBus(clock, {bitrate}, {.bit_error = 1.5, .seed = 1, .restart_after = {}}),
               std::invalid_argument);
  SimBus wire(clock, {bitrate});
  EXPECT_THROW(wire.set_bit_error(-0.1), std::invalid_argument);
  EXPECT_THROW(
      wire.attach()->set_faults({.transmit_bit_error = 0.0, .receive_bit_error = 2.0, .overrun = 0.0}),
      std::invalid_argument);
}

TEST_F(SimBusFaults, AllowANodeToBeDestroyedInItsStateHandlerAndInBusOff) {
  Listener a(wire), b(wire);
  auto leaving = std::make_unique<Listener>(wire);
  leaving->bus->on_state([&](BusState state) {
    if (state == BusState::bus_off) leaving.reset();
  });
  wire.set_bit_error(1.0);
  leaving->bus->send(frame_of(0x100));
  run_for(10ms);
  wire.set_bit_error(0.0);
  EXPECT_EQ(leaving, nullptr);
  force_off(clock, wire, a);
  a.bus->restart();
  a.bus.reset();
  run_for(10ms);
  Listener c(wire);
  b.bus->send(frame_of(0x200));
  run_for(10ms);
  EXPECT_EQ(c.heard.size(), 1U);
}

}  // namespace
}  // namespace hystcan::can::sim_bus_fault_test
