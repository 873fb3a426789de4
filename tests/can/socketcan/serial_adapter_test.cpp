// Cases that neither virtual interfaces nor emulated cards have: the driver itself reaches bus-off, stalls or
// disappears.
#include "tests/can/socketcan/serial_adapter.h"

#include <fmt/format.h>

#include <memory>

#include "tests/can/socketcan/socketcan_fixture.h"
#include "tests/support/shows.h"

namespace hystcan::can::serial_adapter_test {
namespace {

struct SocketCanAdapter : OnVcan {
  void SetUp() override {
    OnVcan::SetUp();
    if (!IsSkipped()) plug_in();
  }
  void plug_in() {
    adapter = std::make_unique<SerialAdapter>();
    if (adapter->name().empty())
      GTEST_SKIP() << "this kernel has no driver for serial CAN adapters, or does not permit its use";
    ASSERT_TRUE(shell("ip link set " + adapter->name() + " up type can bitrate 1000000"));
  }
  std::optional<BusState> state_by_netlink() const { return query_interface(adapter->name())->bus_state; }

  std::unique_ptr<SerialAdapter> adapter;
};

TEST_F(SocketCanAdapter, CarriesFramesInBothDirections) {
  const auto bus = open(adapter->name(), {{0x181}});
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 2, .data = {0xAB, 0xCD}}));
  run_until([&] { return !adapter->frames().empty(); });
  EXPECT_EQ(adapter->frames(), std::vector<std::string>{"t2012ABCD"});
  adapter->send_to_driver("t1801FF");
  adapter->send_to_driver("t181211EE");
  run_until([&] { return !heard.empty(); });
  EXPECT_EQ(heard, (std::vector<Frame>{{.id = 0x181, .length = 2, .data = {0x11, 0xEE}}}));
}

// The messages contain the state, then the receive and the transmit error counter in three digits each.
TEST_F(SocketCanAdapter, LeavesBusOffWhenTheLinkIsSetDownAndUp) {
  const auto bus = open(adapter->name(), {});
  adapter->send_to_driver("sw003096");
  run_until([&] { return bus->state() == BusState::warning; });
  EXPECT_EQ(bus->error_counters(), (ErrorCounters{.transmit = 96, .receive = 3}));
  adapter->send_to_driver("sp003136");
  run_until([&] { return bus->state() == BusState::passive; });
  EXPECT_EQ(bus->error_counters(), (ErrorCounters{.transmit = 136, .receive = 3}));
  EXPECT_EQ(state_by_netlink(), BusState::passive);
  adapter->send_to_driver("sb000256");
  run_until([&] { return bus->state() == BusState::bus_off; });
  context.run_for(200ms);
  context.restart();
  EXPECT_EQ(state_by_netlink(), BusState::bus_off);
  EXPECT_EQ(bus->state(), BusState::bus_off) << "the bus asks every 50 ms, and the driver says bus-off";
  EXPECT_EQ(SocketCanBus(context, adapter->name(), {}).state(), BusState::bus_off)
      << "a bus that is opened now knows the state, too";

  const std::size_t sent_before = adapter->frames().size();
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 1, .data = {0x01}})) << "the kernel would accept the frame";
  ASSERT_TRUE(shell("ip link set " + adapter->name() + " down"));
  run_until([&] { return bus->state() == BusState::down; });
  ASSERT_TRUE(shell("ip link set " + adapter->name() + " up"));
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 1, .data = {0x02}}));
  run_until([&] { return adapter->frames().size() > sent_before; });
  EXPECT_EQ(adapter->frames().back(), "t201102");
  EXPECT_EQ(adapter->frames().size(), sent_before + 1) << "a frame sent in bus-off never arrives";
  EXPECT_EQ(states, (std::vector{BusState::warning, BusState::passive, BusState::bus_off, BusState::down,
                                 BusState::active}));
  EXPECT_EQ(bus->counters().bus_offs, 1U);
}

// The letters mean a: acknowledge, c: CRC, O: transmit overrun.
TEST_F(SocketCanAdapter, CountsTheErrorsThatItsDriverReports) {
  const auto bus = open(adapter->name(), {});
  adapter->send_to_driver("e1a");
  run_until([&] { return bus->counters().error_frames >= 1; });
  EXPECT_EQ(bus->counters().not_acknowledged, 1U);
  EXPECT_EQ(bus->counters().protocol_errors, 0U);
  adapter->send_to_driver("e2cO");
  run_until([&] { return bus->counters().error_frames >= 2; });
  EXPECT_EQ(bus->counters().protocol_errors, 1U);
  EXPECT_EQ(bus->counters().controller_overflows, 1U);
}

TEST_F(SocketCanAdapter, RefusesFramesWhileItIsStalledAndNeverSendsThemLater) {
  shows("S-167");
  const auto bus = open(adapter->name(), {});
  adapter->stall();
  std::vector<std::string> accepted;
  for (std::uint8_t i = 1; i <= 200; ++i)
    if (bus->send({.id = 0x201, .length = 1, .data = {i}})) accepted.push_back(fmt::format("t2011{:02X}", i));
  EXPECT_LE(accepted.size(), 10U) << "the send buffer of the socket and one frame in the driver";
  EXPECT_EQ(bus->counters().send_refused, 200U - accepted.size());
  adapter->resume();
  run_until([&] { return adapter->frames().size() >= accepted.size(); });
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 1, .data = {0xFF}})) << "there is room again";
  accepted.emplace_back("t2011FF");
  run_until([&] { return adapter->frames().size() >= accepted.size(); });
  EXPECT_EQ(adapter->frames(), accepted) << "a refused frame never arrives";
}

TEST_F(SocketCanAdapter, KeepsItsFiltersAfterItWasUnplugged) {
  const std::string name = adapter->name();
  const auto bus = open(name, {{0x181}});
  const int index = query_interface(name)->index;
  adapter.reset();
  run_until([&] { return bus->state() == BusState::down; });
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 8})) << "there is no interface";
  plug_in();
  ASSERT_EQ(adapter->name(), name);
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_NE(query_interface(name)->index, index);
  adapter->send_to_driver("t1801AA");
  adapter->send_to_driver("t1811BB");
  run_until([&] { return !heard.empty(); });
  EXPECT_EQ(heard, (std::vector<Frame>{{.id = 0x181, .length = 1, .data = {0xBB}}}));
}

}  // namespace
}  // namespace hystcan::can::serial_adapter_test
