#include "can/sim/sim_bus.h"

#include <gtest/gtest.h>

#include <array>
#include <span>
#include <vector>

#include "tests/support/count_allocations.h"

namespace hystcan::can::sim_bus_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t bitrate = 1'000'000;
constexpr Duration bit = 1us;

Time at(Duration since_start) { return Time{since_start}; }

Frame frame_of(std::uint32_t id, std::uint8_t length = 8) { return Frame{.id = id, .length = length}; }

struct Heard {
  Frame frame;
  Time received;
};

struct Listener {
  explicit Listener(SimBus& wire, std::span<const Filter> filters = {})
      : bus(wire.attach(TransmitOrder::as_sent, filters)) {
    bus->on_frame([this](const Frame& frame, Time received) { heard.push_back({frame, received}); });
  }
  std::vector<std::uint32_t> ids() const {
    std::vector<std::uint32_t> result;
    for (const Heard& each : heard) result.push_back(each.frame.id);
    return result;
  }
  std::unique_ptr<Bus> bus;
  std::vector<Heard> heard;
};

struct Wired : testing::Test {
  VirtualClock clock;
  SimBus wire{clock, {bitrate}};
};
using SimBusOnTheWire = Wired;
using SimBusArbitration = Wired;
using SimBusNode = Wired;

TEST_F(SimBusOnTheWire, DeliversToEveryOtherNodeWhenTheLastBitHasPassed) {
  Listener a(wire), b(wire), c(wire);
  Frame sent = frame_of(0x201);
  sent.data[3] = 0x5A;
  clock.run_until(at(1ms));
  ASSERT_TRUE(a.bus->send(sent));
  const Time due = at(1ms) + (frame_bits(sent).total() - interframe_bits) * bit;
  clock.run_until(due - 1ns);
  EXPECT_TRUE(b.heard.empty());
  clock.run_until(due);
  for (const Listener* listener : {&b, &c}) {
    ASSERT_EQ(listener->heard.size(), 1U);
    EXPECT_EQ(listener->heard[0].frame, sent);
    EXPECT_EQ(listener->heard[0].received, due);
    EXPECT_EQ(listener->bus->counters().received, 1U);
  }
  EXPECT_TRUE(a.heard.empty()) << "a node does not receive its own frame";
  EXPECT_EQ(a.bus->counters().sent, 1U);
}

TEST_F(SimBusOnTheWire, KeepsTheInterframeSpaceBetweenFrames) {
  Listener a(wire), b(wire);
  a.bus->send(frame_of(0x100));
  a.bus->send(frame_of(0x101));
  clock.run_until(at(10ms));
  ASSERT_EQ(b.heard.size(), 2U);
  EXPECT_EQ(b.heard[1].received - b.heard[0].received, frame_bits(frame_of(0x101)).total() * bit);
}

TEST_F(SimBusOnTheWire, StartsAFrameOnlyAfterTheInterframeSpace) {
  Listener a(wire), b(wire);
  a.bus->send(frame_of(0x100));
  const Duration first = frame_bits(frame_of(0x100)).total() * bit;
  clock.run_until(at(first - 1us));
  a.bus->send(frame_of(0x101));
  clock.run_until(at(10ms));
  ASSERT_EQ(b.heard.size(), 2U);
  EXPECT_EQ(b.heard[1].received, at(first) + (frame_bits(frame_of(0x101)).total() - interframe_bits) * bit);
}

TEST_F(SimBusOnTheWire, GivesTheShareOfBusyTimeAsLoad) {
  Listener a(wire), b(wire);
  EXPECT_EQ(wire.load(), 0.0);
  const Duration one = frame_bits(frame_of(0x100)).total() * bit;
  a.bus->send(frame_of(0x100));
  clock.run_until(at(one / 2));
  EXPECT_NEAR(wire.load(), 1.0, 1e-12);
  clock.run_until(at(4 * one));
  EXPECT_NEAR(wire.load(), 0.25, 1e-12);
}

TEST_F(SimBusArbitration, LetsTheLowestIdentifierWinInAnyOrderOfSending) {
  Listener a(wire), b(wire), c(wire), ear(wire);
  a.bus->send(frame_of(0x300));
  b.bus->send(frame_of(0x100));
  c.bus->send(frame_of(0x200));
  clock.run_until(at(10ms));
  EXPECT_EQ(ear.ids(), (std::vector<std::uint32_t>{0x100, 0x200, 0x300}));
}

TEST_F(SimBusArbitration, NeverInterruptsAFrameOnTheWire) {
  Listener a(wire), b(wire), ear(wire);
  a.bus->send(frame_of(0x700));
  clock.run_until(at(5us));
  b.bus->send(frame_of(0x001));
  clock.run_until(at(10ms));
  EXPECT_EQ(ear.ids(), (std::vector<std::uint32_t>{0x700, 0x001}));
}

TEST_F(SimBusArbitration, OrdersDataRemoteAndExtendedFramesByTheirBits) {
  Listener ear(wire);
  const Frame data = frame_of(0x123);
  const Frame remote{.id = 0x123, .kind = FrameKind::remote, .length = 8};
  const Frame extended{.id = 0x123U << 18U, .extended = true, .length = 8};
  const Frame extended_remote{.id = 0x123U << 18U, .extended = true, .kind = FrameKind::remote, .length = 8};
  const Frame higher{.id = (0x123U << 18U) + 1, .extended = true, .length = 8};
  const Frame next = frame_of(0x124);
  const std::vector<Frame> in_order = {data, remote, extended, extended_remote, higher, next};
  std::vector<std::unique_ptr<Listener>> nodes;
  for (auto frame = in_order.rbegin(); frame != in_order.rend(); ++frame) {
    nodes.push_back(std::make_unique<Listener>(wire));
    ASSERT_TRUE(nodes.back()->bus->send(*frame));
  }
  clock.run_until(at(10ms));
  ASSERT_EQ(ear.heard.size(), in_order.size());
  for (std::size_t i = 0; i < in_order.size(); ++i) EXPECT_EQ(ear.heard[i].frame, in_order[i]) << i;
}

TEST_F(SimBusArbitration, IncludesANodeWhoseTimerIsDueAtTheSameInstant) {
  Listener a(wire), b(wire), ear(wire);
  const auto first = clock.make_timer([&] { a.bus->send(frame_of(0x300)); });
  const auto second = clock.make_timer([&] { b.bus->send(frame_of(0x100)); });
  first->expire_at(at(1ms));
  second->expire_at(at(1ms));
  clock.run_until(at(10ms));
  EXPECT_EQ(ear.ids(), (std::vector<std::uint32_t>{0x100, 0x300}));
}

TEST_F(SimBusNode, SendsItsFramesInTheOrderOfTheCallsOfSend) {
  Listener a(wire), ear(wire);
  for (const std::uint32_t id : {5U, 3U, 4U}) a.bus->send(frame_of(id));
  clock.run_until(at(10ms));
  EXPECT_EQ(ear.ids(), (std::vector<std::uint32_t>{5, 3, 4}));
}

TEST_F(SimBusNode, SendsTheMostUrgentFrameFirstInTheOrderByPriority) {
  Listener ear(wire);
  const auto node = wire.attach(TransmitOrder::by_priority);
  const auto other = wire.attach();
  for (const std::uint32_t id : {5U, 3U, 7U, 3U}) node->send(frame_of(id, static_cast<std::uint8_t>(id)));
  other->send(frame_of(4));
  clock.run_until(at(100us));
  node->send(frame_of(2));
  clock.run_until(at(10ms));
  EXPECT_EQ(ear.ids(), (std::vector<std::uint32_t>{3, 3, 2, 4, 5, 7}));
}

/// The destroyed frame is in the queue again: a more urgent frame that was sent in the meantime precedes it.
TEST_F(SimBusNode, RepeatsADestroyedFrameByItsPriorityInTheOrderByPriority) {
  Listener ear(wire);
  const auto node = wire.attach(TransmitOrder::by_priority);
  wire.set_bit_error(1.0);
  node->send(frame_of(5));
  clock.run_until(at(5us));
  node->send(frame_of(3));
  wire.set_bit_error(0.0);
  clock.run_until(at(10ms));
  EXPECT_EQ(ear.ids(), (std::vector<std::uint32_t>{3, 5}));
}

TEST_F(SimBusNode, RefusesAndCountsAFrameIfItsQueueIsFull) {
  Listener a(wire), ear(wire);
  for (std::size_t i = 0; i < SimBus::transmit_queue_length; ++i) EXPECT_TRUE(a.bus->send(frame_of(0x10)));
  EXPECT_FALSE(a.bus->send(frame_of(0x11)));
  EXPECT_EQ(a.bus->counters().send_refused, 1U);
  EXPECT_EQ(a.bus->counters().sent, SimBus::transmit_queue_length);
  clock.run_until(at(10ms));
  EXPECT_EQ(ear.ids(), std::vector<std::uint32_t>(SimBus::transmit_queue_length, 0x10));
}

TEST_F(SimBusNode, RefusesInvalidFrames) {
  Listener a(wire);
  EXPECT_FALSE(a.bus->send(frame_of(0x800)));
  EXPECT_FALSE(a.bus->send(frame_of(0x100, 9)));
  EXPECT_FALSE(a.bus->send(Frame{.id = 0x2000'0000, .extended = true}));
  EXPECT_FALSE(a.bus->send(Frame{.kind = FrameKind::error}));
  EXPECT_EQ(a.bus->counters().send_refused, 4U);
}

TEST_F(SimBusNode, ReceivesOnlyTheIdentifiersOfItsFilters) {
  const std::array filters{Filter{0x101}, Filter{0x103}};
  Listener ear(wire, filters), all(wire);
  const auto sender = wire.attach();
  for (const std::uint32_t id : {0x100U, 0x101U, 0x102U, 0x103U}) sender->send(frame_of(id));
  sender->send(Frame{.id = 0x101, .extended = true});
  clock.run_until(at(10ms));
  EXPECT_EQ(ear.ids(), (std::vector<std::uint32_t>{0x101, 0x103, 0x101}));
  EXPECT_EQ(ear.bus->counters().received, 3U);
  EXPECT_EQ(all.heard.size(), 5U);
}

TEST_F(SimBusNode, AcknowledgesTheFramesThatItsFiltersDoNotPass) {
  const std::array filters{Filter{0x101}};
  Listener ear(wire, filters);
  const auto sender = wire.attach();
  sender->send(frame_of(0x100));
  clock.run_until(at(10ms));
  EXPECT_EQ(sender->counters().not_acknowledged, 0U);
}

TEST_F(SimBusNode, ReceivesIdentifiersUsedBeforeItWasAttached) {
  const auto sender = wire.attach();
  Listener first(wire);
  sender->send(frame_of(0x101));
  clock.run_until(at(10ms));
  const std::array filters{Filter{0x101}};
  Listener second(wire, filters);
  sender->send(frame_of(0x101));
  clock.run_until(at(20ms));
  EXPECT_EQ(second.ids(), std::vector<std::uint32_t>{0x101});
}

TEST_F(SimBusNode, MayBeDestroyedWithQueuedFramesAndOneFrameOnTheWire) {
  Listener ear(wire);
  auto leaving = wire.attach();
  for (int i = 0; i < 3; ++i) leaving->send(frame_of(0x100));
  clock.run_until(at(5us));
  leaving.reset();
  clock.run_until(at(10ms));
  EXPECT_EQ(ear.ids(), std::vector<std::uint32_t>{0x100}) << "only the frame on the wire arrives";
}

TEST_F(SimBusNode, MayDestroyItselfAndAnotherNodeInItsFrameHandler) {
  Listener sender(wire);
  auto leaving = wire.attach();
  auto other = wire.attach();
  Listener ear(wire);
  int heard = 0;
  const std::string content(100, 'x');  // the handler owns it, and must outlive its node
  std::string seen;
  leaving->on_frame([&, content](const Frame&, Time) {
    ++heard;
    leaving.reset();
    other.reset();
    seen = content;
  });
  other->on_frame([](const Frame&, Time) { FAIL() << "destroyed before it received the frame"; });
  sender.bus->send(frame_of(0x100));
  sender.bus->send(frame_of(0x101));
  clock.run_until(at(10ms));
  EXPECT_EQ(heard, 1);
  EXPECT_EQ(seen, content);
  EXPECT_EQ(ear.heard.size(), 2U);
}

TEST_F(SimBusNode, ReceivesOnlyTheNextFrameIfItIsAttachedDuringADelivery) {
  Listener sender(wire);
  std::unique_ptr<Listener> late;
  const auto host = wire.attach();
  host->on_frame([&](const Frame&, Time) {
    if (!late) late = std::make_unique<Listener>(wire);
  });
  sender.bus->send(frame_of(0x100));
  sender.bus->send(frame_of(0x101));
  clock.run_until(at(10ms));
  EXPECT_EQ(late->ids(), std::vector<std::uint32_t>{0x101});
}

TEST(SimBusLifetime, MayEndInTheFrameHandlerOfTheLastNode) {
  VirtualClock clock;
  auto wire = std::make_unique<SimBus>(clock, BitRates{bitrate});
  auto sender = wire->attach();
  auto receiver = wire->attach();
  bool heard = false;
  receiver->on_frame([&](const Frame&, Time) {
    heard = true;
    sender.reset();
    wire.reset();
    receiver.reset();
  });
  sender->send(frame_of(0x100));
  clock.run_until(at(10ms));
  EXPECT_TRUE(heard);
}

TEST(SimBusLifetime, RefusesABitRateOfZero) {
  VirtualClock clock;
  EXPECT_THROW(SimBus(clock, {0}), std::invalid_argument);
}

TEST(SimBusSteadyState, AllocatesNothing) {
  VirtualClock clock;
  SimBus wire(clock, {bitrate});
  const auto a = wire.attach();
  const auto b = wire.attach();
  std::uint64_t frames = 0;
  const auto answer = [&frames](Bus& bus) {
    return [&frames, &bus](const Frame& frame, Time) {
      ++frames;
      bus.send(frame);
    };
  };
  a->on_frame(answer(*a));
  b->on_frame(answer(*b));
  a->send(frame_of(0x201));
  clock.run_until(at(10ms));
  const std::uint64_t frames_before = frames;
  const std::uint64_t before = support::allocations_so_far();
  clock.run_until(at(1s));
  EXPECT_EQ(support::allocations_so_far() - before, 0U);
  EXPECT_GT(frames - frames_before, 5000U);
}

}  // namespace
}  // namespace hystcan::can::sim_bus_test
