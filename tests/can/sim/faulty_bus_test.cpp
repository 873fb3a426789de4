#include "can/sim/faulty_bus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "can/protocol/protocol.h"
#include "can/sim/sim_bus.h"
#include "tests/support/count_allocations.h"

namespace hystcan::can::faulty_bus_test {
namespace {

using namespace std::chrono_literals;

const Database& shipped() {
  static const Database database = load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  return database;
}

/// A sender on a simulated bus and a faulty receiver, which decodes the sender's samples.
struct Lossy {
  explicit Lossy(std::vector<FaultRule> rules, std::uint64_t seed = 1)
      : bus(wire.attach(), clock, {.seed = seed, .rules = std::move(rules)}) {
    bus.on_frame([this](const Frame& frame, Time received) {
      heard.push_back(frame);
      times.push_back(received);
      if (frame.id == decode.id()) decoded += decode(frame) ? 1 : 0;
    });
  }

  /// Sends `count` samples, 1 ms apart. Counter and position identify each one.
  void send(int count) {
    for (int i = 0; i < count; ++i) {
      sent.push_back(*encode({.position_um = 0.001 * i, .sync_counter = 1, .status = 0}));
      remote->send(sent.back());
      clock.run_until(clock.now() + 1ms);
    }
    clock.run_until(clock.now() + 100ms);
  }
  std::uint64_t rejected(Rejection cause) const { return decode.checker().rejected(cause); }
  std::uint64_t rejected_in_all() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < rejection_count; ++i) sum += rejected(static_cast<Rejection>(i));
    return sum;
  }

  VirtualClock clock;
  SimBus wire{clock, 1'000'000};
  std::unique_ptr<SimNode> remote = wire.attach();
  FaultyBus bus;
  Encoder<SensorSample> encode{*shipped().find("XSensorSample")};
  Decoder<SensorSample> decode{*shipped().find("XSensorSample")};
  std::vector<Frame> sent;
  std::vector<Frame> heard;
  std::vector<Time> times;
  std::uint64_t decoded = 0;
};

FaultRule rule(BusFault fault, double probability) {
  return {.fault = fault, .probability = probability, .only = {}};
}

TEST(FaultyBus, ChangesNothingWithoutRules) {
  Lossy line({});
  line.send(100);
  EXPECT_EQ(line.heard, line.sent);
  EXPECT_EQ(line.decoded, 100U);
  EXPECT_TRUE(line.bus.send({.id = 0x100, .length = 1}));
  EXPECT_EQ(line.bus.counters().sent, 1U);
  EXPECT_EQ(line.bus.state(), BusState::active);
  EXPECT_TRUE(line.bus.error_counters());
}

TEST(FaultyBus, LosesAsManyFramesAsItCounts) {
  Lossy line({rule(BusFault::lose, 0.3)});
  line.send(1000);
  const auto lost = line.bus.injected(BusFault::lose);
  EXPECT_NEAR(static_cast<double>(lost), 300, 60) << "four standard deviations";
  EXPECT_EQ(line.heard.size(), 1000 - lost);
  EXPECT_EQ(line.rejected_in_all(), line.rejected(Rejection::repeated_counter));
  EXPECT_EQ(line.decoded + line.rejected(Rejection::repeated_counter), line.heard.size());
}

TEST(FaultyBus, DelaysFramesAndGivesTheLaterTimeOfArrival) {
  FaultRule late = rule(BusFault::delay, 1.0);
  late.delay = 400us;
  Lossy line({late});
  line.send(200);
  EXPECT_EQ(line.heard, line.sent);
  EXPECT_EQ(line.bus.injected(BusFault::delay), 200U);
  Duration longest{};
  for (std::size_t i = 0; i < line.times.size(); ++i) {
    const Time on_wire = Time{i * 1ms} + (frame_bits(line.sent[i]) - interframe_bits) * 1us;
    EXPECT_GT(line.times[i], on_wire);
    EXPECT_LE(line.times[i], on_wire + 400us);
    longest = std::max(longest, line.times[i] - on_wire);
  }
  EXPECT_GT(longest, 350us);
}

TEST(FaultyBus, DuplicatesFramesAndTheCheckerCountsRepeatedCounters) {
  Lossy line({rule(BusFault::duplicate, 0.2)});
  line.send(500);
  const auto doubled = line.bus.injected(BusFault::duplicate);
  EXPECT_GT(doubled, 50U);
  EXPECT_EQ(line.heard.size(), 500 + doubled);
  EXPECT_EQ(line.rejected(Rejection::repeated_counter), doubled);
  EXPECT_EQ(line.decoded, 500U);
}

TEST(FaultyBus, ReordersAFrameWithTheNextOne) {
  FaultRule swap = rule(BusFault::reorder, 0.2);
  swap.delay = 20ms;
  Lossy line({swap});
  line.send(500);
  ASSERT_EQ(line.heard.size(), 500U);
  EXPECT_GT(line.bus.injected(BusFault::reorder), 50U);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < 500; ++i) moved += line.heard[i] == line.sent[i] ? 0 : 1;
  EXPECT_GT(moved, 50U);
  EXPECT_TRUE(std::ranges::is_permutation(line.heard, line.sent));
}

TEST(FaultyBus, DeliversAReorderedFrameAfterTheDelayIfNoFrameFollows) {
  FaultRule swap = rule(BusFault::reorder, 1.0);
  swap.delay = 20ms;
  Lossy line({swap});
  line.send(1);
  EXPECT_EQ(line.heard, line.sent);
  EXPECT_EQ(line.times[0], Time{20ms} + (frame_bits(line.sent[0]) - interframe_bits) * 1us);
}

struct Corruption {
  const char* name;
  BusFault fault;
  Rejection rejection;

  friend void PrintTo(const Corruption& corruption, std::ostream* out) { *out << corruption.name; }
};
class FaultyBusCorrupts : public testing::TestWithParam<Corruption> {};

TEST_P(FaultyBusCorrupts, OneFieldAndTheCheckerCountsItsCause) {
  Lossy line({rule(GetParam().fault, 0.2)});
  line.send(500);
  const auto injected = line.bus.injected(GetParam().fault);
  EXPECT_GT(injected, 50U);
  EXPECT_EQ(line.heard.size(), 500U);
  EXPECT_EQ(line.rejected(GetParam().rejection), injected);
  EXPECT_EQ(line.rejected_in_all(), injected) << "no other field changes";
  EXPECT_EQ(line.decoded, 500 - injected);
}

INSTANTIATE_TEST_SUITE_P(
    EachField, FaultyBusCorrupts,
    testing::Values(Corruption{"Payload", BusFault::corrupt_payload, Rejection::wrong_crc},
                    Corruption{"Length", BusFault::corrupt_length, Rejection::wrong_length},
                    Corruption{"Kind", BusFault::corrupt_kind, Rejection::wrong_kind},
                    Corruption{"Extension", BusFault::corrupt_extension, Rejection::extended_id}),
    [](const auto& param) { return std::string(param.param.name); });

TEST(FaultyBus, CorruptsAnIdentifierSoThatNoReceiverAcceptsTheFrame) {
  Lossy line({rule(BusFault::corrupt_id, 0.2)});
  line.send(500);
  const auto injected = line.bus.injected(BusFault::corrupt_id);
  EXPECT_GT(injected, 50U);
  EXPECT_EQ(std::ranges::count(line.heard, 0x182U, &Frame::id), 500 - static_cast<std::ptrdiff_t>(injected));
  Decoder<AmpStatus> other(*shipped().find("XAmpStatus"));
  Frame strayed = line.sent[0];
  strayed.id = other.id();
  EXPECT_FALSE(other(strayed)) << "the CRC covers the identifier";
  EXPECT_EQ(other.checker().rejected(Rejection::wrong_crc), 1U);
}

TEST(FaultyBus, AppliesARuleOnlyToItsIdentifierAndDirection) {
  FaultRule only = rule(BusFault::lose, 1.0);
  only.only = Filter{.id = 0x182};
  Lossy line({only});
  line.remote->send({.id = 0x183, .length = 2});
  line.remote->send({.id = 0x182, .extended = true, .length = 2});
  line.send(10);
  EXPECT_EQ(line.heard.size(), 2U);
  EXPECT_EQ(line.bus.injected(BusFault::lose), 10U);

  int reached = 0;
  line.remote->on_frame([&](const Frame&, Time) { ++reached; });
  EXPECT_TRUE(line.bus.send({.id = 0x182, .length = 2})) << "the rule applies to received frames";
  line.clock.run_until(line.clock.now() + 1ms);
  EXPECT_EQ(reached, 1);
}

TEST(FaultyBus, LosesTransmittedFramesByATransmitRule) {
  FaultRule sending = rule(BusFault::lose, 1.0);
  sending.on_receive = false;
  sending.on_transmit = true;
  Lossy line({sending});
  int reached = 0;
  line.remote->on_frame([&](const Frame&, Time) { ++reached; });
  EXPECT_TRUE(line.bus.send({.id = 0x200, .length = 2}))
      << "the sender cannot detect the loss, as on a real bus";
  line.send(3);
  EXPECT_EQ(reached, 0);
  EXPECT_EQ(line.heard.size(), 3U);
}

TEST(FaultyBus, RepeatsItsResultsForTheSameSeed) {
  const auto run = [](std::uint64_t seed) {
    Lossy line({rule(BusFault::lose, 0.1), rule(BusFault::delay, 0.3), rule(BusFault::corrupt_payload, 0.2)},
               seed);
    line.send(200);
    return std::pair(line.heard, line.times);
  };
  EXPECT_EQ(run(3), run(3));
  EXPECT_NE(run(3), run(4));
}

TEST(FaultyBus, AllocatesNothingWhileItRuns) {
  Lossy line({rule(BusFault::delay, 0.5), rule(BusFault::reorder, 0.3), rule(BusFault::duplicate, 0.3)});
  line.heard.reserve(4000);
  line.times.reserve(4000);
  line.sent.reserve(4000);
  line.send(10);
  const auto before = support::allocations_so_far();
  line.send(1000);
  EXPECT_EQ(support::allocations_so_far() - before, 0U);
}

TEST(FaultyBus, RefusesAnInvalidRule) {
  EXPECT_THROW(Lossy({rule(BusFault::lose, 1.1)}), std::invalid_argument);
  FaultRule backwards = rule(BusFault::delay, 0.5);
  backwards.delay = -1ms;
  EXPECT_THROW(Lossy({backwards}), std::invalid_argument);
}

TEST(FaultyBus, AcceptsNewRulesWhileItRuns) {
  Lossy lossy({});
  lossy.send(10);
  lossy.bus.set_rules({{.fault = BusFault::lose, .probability = 1.0, .only = {}}});
  lossy.send(10);
  lossy.bus.set_rules({});
  lossy.send(10);
  EXPECT_EQ(lossy.heard.size(), 20u);
  EXPECT_THROW(lossy.bus.set_rules({{.fault = BusFault::lose, .probability = 1.5, .only = {}}}),
               std::invalid_argument);
}

/// A rule holds a frame and is then removed. The next frame releases the held one, as under the rule.
TEST(FaultyBus, ReleasesAFrameThatARemovedRuleHeld) {
  Lossy lossy({{.fault = BusFault::reorder, .probability = 1.0, .only = {}, .delay = 1s}});
  lossy.remote->send(can::sync_frame(1));
  lossy.clock.run_until(lossy.clock.now() + 1ms);
  ASSERT_TRUE(lossy.heard.empty());
  lossy.bus.set_rules({});
  lossy.remote->send(can::sync_frame(2));
  lossy.clock.run_until(lossy.clock.now() + 1ms);
  ASSERT_EQ(lossy.heard.size(), 2u);
  EXPECT_EQ(lossy.heard.back(), can::sync_frame(1));
}

}  // namespace
}  // namespace hystcan::can::faulty_bus_test
