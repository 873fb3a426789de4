// The SJA1000 controllers of the guest, if it has them. The driver treats them as real ones, and they share
// one wire.
#include "tests/can/socketcan/socketcan_fixture.h"

namespace hystcan::can::socketcan_controller_test {
namespace {

struct SocketCanController : testing::Test {
  void SetUp() override {
    for (const char* name : {"can0", "can1"}) {
      const auto found = query_interface(name);
      if (!found || !found->up) GTEST_SKIP() << "there is no interface " << name << " that is up";
    }
  }
  boost::asio::io_context context;
};

TEST_F(SocketCanController, IsNotVirtual) { EXPECT_FALSE(is_virtual_interface("can0")); }

TEST_F(SocketCanController, HasTheSettingsOfIpLink) {
  const auto found = query_interface("can0");
  EXPECT_EQ(found->kind, "can");
  EXPECT_EQ(found->bus_state, BusState::active);
  EXPECT_EQ(found->bitrate_bit_per_s, 1'000'000U);
  EXPECT_EQ(found->restart_ms, 100U);
  EXPECT_GT(found->transmit_queue_frames, 0U);
  EXPECT_FALSE(found->queue_discipline.empty());
  EXPECT_TRUE(found->bus_offs.has_value());
  EXPECT_TRUE(find_warnings("can0", *found).empty());
  EXPECT_THROW(require_bit_rate("can0", *found, {.nominal_bit_per_s = 500'000}), RunError);
  std::printf("%s\n", describe("can0", *found).c_str());
}

TEST_F(SocketCanController, IsRefusedForASendingNodeIfItIsListenOnly) {
  ASSERT_TRUE(shell("ip link set can1 down && ip link set can1 up type can listen-only on"));
  const Interface found = require_can_interface("can1");
  EXPECT_TRUE(found.listen_only);
  EXPECT_THROW(require_able_to_send("can1", found), RunError);
  ASSERT_TRUE(shell("ip link set can1 down && ip link set can1 up type can listen-only off"));
  EXPECT_NO_THROW(require_able_to_send("can1", require_can_interface("can1")));
}

TEST_F(SocketCanController, IsUnusedUntilItHasItsInitialSettings) {
  SocketCanBus bus(context, "can1", {});
  ASSERT_TRUE(shell("ip link set can1 down && ip link set can1 up type can listen-only on"));
  run_until(context, [&] { return bus.refusal() == Refusal::listen_only; });
  EXPECT_EQ(bus.state(), BusState::down);
  ASSERT_TRUE(shell("ip link set can1 down && ip link set can1 up type can listen-only off bitrate 500000"));
  run_until(context, [&] { return bus.refusal() == Refusal::other_bit_rate; });
  EXPECT_FALSE(bus.send({.id = 0x201, .length = 8}));
  ASSERT_TRUE(shell("ip link set can1 down && ip link set can1 up type can bitrate 1000000"));
  run_until(context, [&] { return bus.state() == BusState::active; });
  EXPECT_EQ(bus.refusal(), Refusal::none);
}

TEST_F(SocketCanController, CarriesFramesToTheOtherController) {
  SocketCanBus sender(context, "can0", {});
  SocketCanBus receiver(context, "can1", std::vector<Filter>{{0x201}});
  std::vector<Frame> heard;
  receiver.on_frame([&](const Frame& frame, Time) { heard.push_back(frame); });
  const Frame sent{.id = 0x201, .length = 8, .data = {1, 2, 3, 4, 5, 6, 7, 8}};
  EXPECT_TRUE(sender.send({.id = 0x203, .length = 8}));
  EXPECT_TRUE(sender.send(sent));
  run_until(context, [&] { return !heard.empty(); });
  EXPECT_EQ(heard, std::vector{sent});
  EXPECT_EQ(sender.state(), BusState::active);
}

}  // namespace
}  // namespace hystcan::can::socketcan_controller_test
