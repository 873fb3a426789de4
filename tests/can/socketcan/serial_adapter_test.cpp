// What no virtual interface and no emulated card does: the driver itself goes bus-off, stalls, vanishes.
#include "tests/can/socketcan/serial_adapter.h"

#include <fmt/format.h>

#include <memory>

#include "tests/can/socketcan/socketcan_fixture.h"

namespace hystcan::can {
namespace {

struct SocketCanAdapter : OnVcan {
  void SetUp() override {
    OnVcan::SetUp();
    if (!IsSkipped()) plug_in();
  }
  void plug_in() {
    adapter = std::make_unique<SerialAdapter>();
    if (adapter->name().empty())
      GTEST_SKIP() << "this kernel has no serial CAN adapters, or lets us have none";
    ASSERT_TRUE(shell("ip link set " + adapter->name() + " up type can bitrate 1000000"));
  }
  std::optional<BusState> state_by_netlink() const { return query_interface(adapter->name())->bus_state; }

  std::unique_ptr<SerialAdapter> adapter;
};

TEST_F(SocketCanAdapter, CarriesFramesBothWays) {
  const auto bus = open(adapter->name(), {{0x181}});
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 2, .data = {0xAB, 0xCD}}));
  run_until([&] { return !adapter->frames().empty(); });
  EXPECT_EQ(adapter->frames(), std::vector<std::string>{"t2012ABCD"});
  adapter->say("t1801FF");
  adapter->say("t181211EE");
  run_until([&] { return !heard.empty(); });
  EXPECT_EQ(heard, (std::vector<Frame>{{.id = 0x181, .length = 2, .data = {0x11, 0xEE}}}));
}

// State, then receive and transmit error counter in three digits each.
TEST_F(SocketCanAdapter, IsWarnedPassiveAndBusOffByItsDriverUntilItsLinkGoesDownAndUp) {
  const auto bus = open(adapter->name(), {});
  adapter->say("sw003096");
  run_until([&] { return bus->state() == BusState::warning; });
  EXPECT_EQ(bus->error_counters(), (ErrorCounters{.transmit = 96, .receive = 3}));
  adapter->say("sp003136");
  run_until([&] { return bus->state() == BusState::passive; });
  EXPECT_EQ(bus->error_counters(), (ErrorCounters{.transmit = 136, .receive = 3}));
  EXPECT_EQ(state_by_netlink(), BusState::passive);
  adapter->say("sb000256");
  run_until([&] { return bus->state() == BusState::bus_off; });
  context.run_for(200ms);
  context.restart();
  EXPECT_EQ(state_by_netlink(), BusState::bus_off);
  EXPECT_EQ(bus->state(), BusState::bus_off) << "asked for every 50 ms, and told so by the driver";
  EXPECT_EQ(SocketCanBus(context, adapter->name(), {}).state(), BusState::bus_off)
      << "known to who opens it now";

  const std::size_t sent_before = adapter->frames().size();
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 1, .data = {0x01}})) << "the kernel would take it";
  ASSERT_TRUE(shell("ip link set " + adapter->name() + " down"));
  run_until([&] { return bus->state() == BusState::down; });
  ASSERT_TRUE(shell("ip link set " + adapter->name() + " up"));
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 1, .data = {0x02}}));
  run_until([&] { return adapter->frames().size() > sent_before; });
  EXPECT_EQ(adapter->frames().back(), "t201102");
  EXPECT_EQ(adapter->frames().size(), sent_before + 1) << "what was sent in bus-off never comes";
  EXPECT_EQ(states, (std::vector{BusState::warning, BusState::passive, BusState::bus_off, BusState::down,
                                 BusState::active}));
  EXPECT_EQ(bus->counters().bus_offs, 1U);
}

// a: acknowledge, c: CRC, O: transmit overrun.
TEST_F(SocketCanAdapter, TellsErrorsOfTheWireByItsDriver) {
  const auto bus = open(adapter->name(), {});
  adapter->say("e1a");
  run_until([&] { return bus->counters().error_frames >= 1; });
  EXPECT_EQ(bus->counters().not_acknowledged, 1U);
  EXPECT_EQ(bus->counters().protocol_errors, 0U);
  adapter->say("e2cO");
  run_until([&] { return bus->counters().error_frames >= 2; });
  EXPECT_EQ(bus->counters().protocol_errors, 1U);
  EXPECT_EQ(bus->counters().controller_overflows, 1U);
}

TEST_F(SocketCanAdapter, ThatTakesNothingMoreIsRefusedFramesAndLaterSentTheLatestOnly) {
  const auto bus = open(adapter->name(), {});
  adapter->stall();
  std::vector<std::string> accepted;
  for (std::uint8_t i = 1; i <= 200; ++i)
    if (bus->send({.id = 0x201, .length = 1, .data = {i}})) accepted.push_back(fmt::format("t2011{:02X}", i));
  EXPECT_LE(accepted.size(), 10U) << "what the socket may have unsent, and one under way";
  EXPECT_EQ(bus->counters().send_refused, 200U - accepted.size());
  adapter->go_on();
  run_until([&] { return adapter->frames().size() >= accepted.size(); });
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 1, .data = {0xFF}})) << "there is room again";
  accepted.emplace_back("t2011FF");
  run_until([&] { return adapter->frames().size() >= accepted.size(); });
  EXPECT_EQ(adapter->frames(), accepted) << "what was refused never comes";
}

TEST_F(SocketCanAdapter, UnpluggedAndPluggedInIsFoundAgainWithItsFilters) {
  const std::string name = adapter->name();
  const auto bus = open(name, {{0x181}});
  const int index = query_interface(name)->index;
  adapter.reset();
  run_until([&] { return bus->state() == BusState::down; });
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 8})) << "there is nothing to send on";
  plug_in();
  ASSERT_EQ(adapter->name(), name);
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_NE(query_interface(name)->index, index);
  adapter->say("t1801AA");
  adapter->say("t1811BB");
  run_until([&] { return !heard.empty(); });
  EXPECT_EQ(heard, (std::vector<Frame>{{.id = 0x181, .length = 1, .data = {0xBB}}}));
}

}  // namespace
}  // namespace hystcan::can
