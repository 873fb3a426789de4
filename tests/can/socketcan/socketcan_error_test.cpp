// SocketCanBus receives error frames: state, error counters and errors of the wire.
#include "tests/can/socketcan/socketcan_fixture.h"

namespace hystcan::can::socketcan_error_test {
namespace {

// The error frames are those of canerrsim (can-utils): CAN_ERR_FLAG and the class in the identifier, eight
// bytes.
TEST_F(SocketCanInterface, GivesStateAndErrorCountersFromErrorFrames) {
  const auto bus = open("vcan9", {{0x181}});
  EXPECT_EQ(bus->error_counters(), std::nullopt);
  ASSERT_TRUE(shell("cansend vcan9 20000204#0008000000006003"));
  run_until([&] { return bus->state() == BusState::warning; });
  EXPECT_EQ(bus->error_counters(), (ErrorCounters{.transmit = 96, .receive = 3}));
  ASSERT_TRUE(shell("cansend vcan9 20000204#0020000000008803"));
  run_until([&] { return bus->state() == BusState::passive; });
  EXPECT_EQ(bus->error_counters(), (ErrorCounters{.transmit = 136, .receive = 3}));
  ASSERT_TRUE(shell("cansend vcan9 20000040#0000000000000000"));
  run_until([&] { return bus->state() == BusState::bus_off; });
  context.run_for(200ms);
  context.restart();
  EXPECT_EQ(bus->state(), BusState::bus_off) << "vcan has no state, so only the restart ends bus-off";
  ASSERT_TRUE(shell("cansend vcan9 20000100#0000000000000000"));
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_EQ(states, (std::vector{BusState::warning, BusState::passive, BusState::bus_off, BusState::active}));
  EXPECT_EQ(bus->counters().warnings, 1U);
  EXPECT_EQ(bus->counters().passives, 1U);
  EXPECT_EQ(bus->counters().bus_offs, 1U);
  EXPECT_EQ(bus->counters().restarts, 1U);
  EXPECT_EQ(bus->counters().error_frames, 4U);
  EXPECT_TRUE(heard.empty()) << "error frames do not reach the frame handler";
}

TEST_F(SocketCanInterface, CountsTheCausesOfErrorFrames) {
  const auto bus = open("vcan9", {{0x181}});
  for (const char* frame :
       {"20000020#0000000000000000", "20000002#0500000000000000", "20000088#0000040800000000",
        "20000004#0001000000000000", "20000010#0000000004000000"}) {
    ASSERT_TRUE(shell(std::string("cansend vcan9 ") + frame)) << frame;
  }
  run_until([&] { return bus->counters().error_frames >= 5; });
  EXPECT_EQ(bus->counters().not_acknowledged, 1U);
  EXPECT_EQ(bus->counters().arbitration_lost, 1U);
  EXPECT_EQ(bus->counters().protocol_errors, 1U);
  EXPECT_EQ(bus->counters().controller_overflows, 1U);
  EXPECT_EQ(bus->counters().transceiver_errors, 1U);
  EXPECT_EQ(bus->state(), BusState::active);
}

TEST_F(SocketCanInterface, LeavesBusOffWhenItIsSetDownAndUp) {
  const auto bus = open("vcan9", {});
  ASSERT_TRUE(shell("cansend vcan9 20000040#0000000000000000"));
  run_until([&] { return bus->state() == BusState::bus_off; });
  ASSERT_TRUE(shell("ip link set vcan9 down"));
  run_until([&] { return bus->state() == BusState::down; });
  ASSERT_TRUE(shell("ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
}

}  // namespace
}  // namespace hystcan::can::socketcan_error_test
