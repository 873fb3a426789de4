// The interface is set down and up, deleted and created again with the same name.
#include "tests/can/socketcan/socketcan_fixture.h"

#include <thread>

#include "tests/support/refusal.h"
#include "tests/support/shows.h"

namespace hystcan::can::socketcan_interface_test {
namespace {

std::string refusal(const std::string& interface) {
  boost::asio::io_context context;
  return support::refusal_of<RunError>([&] { SocketCanBus bus(context, interface, {}); });
}

TEST_F(SocketCanInterface, ContinuesAfterItWasDown) {
  const auto bus = open("vcan9", {{0x181}});
  EXPECT_EQ(bus->state(), BusState::active);
  ASSERT_TRUE(shell("ip link set vcan9 down"));
  run_until([&] { return bus->state() == BusState::down; });
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 8}));
  EXPECT_EQ(bus->counters().send_refused, 1U);

  ASSERT_TRUE(shell("ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 8}));
  ASSERT_TRUE(shell("cansend vcan9 181#11 && cansend vcan9 182#12"));
  run_until([&] { return !heard.empty(); });
  EXPECT_EQ(states, (std::vector{BusState::down, BusState::active}));
}

TEST_F(SocketCanInterface, EndsTheWaitInTheSocketAndWaitsThereAgainAfterItIsUp) {
  const auto bus = open("vcan9", {{0x181}});
  const Time patient = std::chrono::steady_clock::now() + support::patience;
  std::thread other([] {
    std::this_thread::sleep_for(20ms);
    EXPECT_TRUE(shell("ip link set vcan9 down"));
  });
  EXPECT_FALSE(bus->receive_before(patient));
  other.join();
  EXPECT_EQ(bus->state(), BusState::down);
  EXPECT_FALSE(bus->receive_before(patient)) << "does not wait";
  ASSERT_TRUE(shell("ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
  ASSERT_TRUE(shell("cansend vcan9 181#33"));
  EXPECT_TRUE(bus->receive_before(patient));
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_EQ(heard[0].data[0], 0x33);
}

TEST_F(SocketCanInterface, IsDownAfterAFailedSend) {
  const auto bus = open("vcan9", {});
  ASSERT_TRUE(shell("ip link set vcan9 down"));
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 8}));
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 8}));
  run_until([&] { return bus->state() == BusState::down; });
  EXPECT_EQ(bus->counters().send_refused, 2U);
  ASSERT_TRUE(shell("ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 8}));
}

TEST_F(SocketCanInterface, ContinuesAfterItWasDeletedAndCreatedAgain) {
  shows("S-168");
  const auto bus = open("vcan9", {{0x181}});
  ASSERT_TRUE(shell("ip link del vcan9"));
  run_until([&] { return bus->state() == BusState::down; });
  ASSERT_TRUE(shell("ip link add dev vcan9 type vcan && ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
  ASSERT_TRUE(shell("cansend vcan9 181#22"));
  run_until([&] { return !heard.empty(); });
  EXPECT_EQ(heard[0].data[0], 0x22);
}

TEST_F(SocketCanInterface, RestoresItsFiltersOnANewInterface) {
  const auto bus = open("vcan9", {{0x181}});
  const int index = query_interface("vcan9")->index;
  ASSERT_TRUE(shell("ip link del vcan9"));
  run_until([&] { return bus->state() == BusState::down; });
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 8})) << "there is no interface";
  ASSERT_TRUE(shell("ip link add dev vcan9 type vcan && ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_NE(query_interface("vcan9")->index, index)
      << "like a USB adapter that was unplugged and plugged in again";
  ASSERT_TRUE(shell("cansend vcan9 180#01 && cansend vcan9 182#02 && cansend vcan9 181#03"));
  run_until([&] { return !heard.empty(); });
  context.poll();
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_EQ(heard[0].data[0], 3);
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 8}));
}

TEST_F(SocketCanInterface, IsRefusedWithItsRemedyIfItIsDownOrAbsent) {
  ASSERT_TRUE(shell("ip link set vcan9 down"));
  EXPECT_EQ(refusal("vcan9"), "interface vcan9 is down; bring it up with: ip link set vcan9 up");
  EXPECT_EQ(refusal("vcan7"),
            "interface vcan7 does not exist; create it with: ip link add dev vcan7 type vcan && ip link set "
            "vcan7 up");
  EXPECT_EQ(refusal("lo"), "interface lo is not a CAN interface");
}

TEST_F(SocketCanInterface, IsVirtual) {
  EXPECT_TRUE(is_virtual_interface("vcan0"));
  EXPECT_TRUE(is_virtual_interface("vcan9"));
}

}  // namespace
}  // namespace hystcan::can::socketcan_interface_test
