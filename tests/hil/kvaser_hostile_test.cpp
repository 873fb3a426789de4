// Two SJA1000 controllers with their real driver on one wire, while the axes track.
//
// QEMU's model of the SJA1000 always acknowledges and never has errors on the wire: receive overrun is its
// only status bit, error counters and bit timing read 0, and nodes with different bit rates understand each
// other. Therefore the driver's own bus-off cannot occur here. The tests send error frames in the format of
// canerrsim instead; tests/can/socketcan/serial_adapter_test.cpp covers a driver in bus-off.
#include <gtest/gtest.h>

#include <thread>

#include "tests/hil/live_bench.h"
#include "tests/support/shows.h"

namespace hystcan::kvaser_hostile_test {
namespace {

using hil::json;
using hil::LiveBench;
using hil::milliseconds;
using hil::shell;

struct KvaserHostile : testing::Test {
  void SetUp() override {
    bench.start_controller({"--json"});
    ASSERT_TRUE(bench.tracks()) << bench.controller->err();
  }
  ~KvaserHostile() override { shell("tc qdisc del dev can0 root 2>/dev/null"); }
  LiveBench bench{{"can0", "can1"}};
};

// 50 ms later the driver reports that it is not in bus-off. The bus-off therefore ends without a restart
// frame; the axes stay disarmed.
TEST_F(KvaserHostile, BusOffDisarmsEvenIfTheDriverDoesNotReportIt) {
  EXPECT_FALSE(shell("ip link set can0 type can restart 2>/dev/null"))
      << "the driver restarts from bus-off only";
  ASSERT_TRUE(shell("cansend can0 20000040#0000000000000000"));
  EXPECT_TRUE(bench.controller->says("x: faulted")) << bench.controller->err();
  EXPECT_TRUE(bench.controller->says("can0: bus bus-off at")) << bench.controller->err();
  EXPECT_TRUE(bench.controller->says("can0: bus active at")) << bench.controller->err();
  std::this_thread::sleep_for(milliseconds(300));
  const json result = bench.stop_and_report(1);
  for (const json& axis : result.at("axes")) EXPECT_EQ(axis.at("fault"), "bus-off");
  EXPECT_EQ(result.at("bus").at("bus_offs"), 1);
  EXPECT_EQ(result.at("bus").at("restarts"), 0);
  bench.start_controller({"--clear-faults"});
  EXPECT_TRUE(bench.tracks()) << bench.controller->err();
}

// The queue accepts every frame and releases one every 8 ms, as on a bus that others fill. The driver echoes
// a frame when it was sent: the controller detects late commands before samples are missing.
TEST_F(KvaserHostile, CommandsWaitingInTheQueueFaultAsLate) {
  shows("S-048");
  ASSERT_TRUE(shell("tc qdisc replace dev can0 root tbf rate 16kbit burst 20 limit 3200"));
  EXPECT_TRUE(bench.controller->says("x: faulted")) << bench.controller->err();
  EXPECT_TRUE(bench.controller->says("y: faulted")) << bench.controller->err();
  ASSERT_TRUE(shell("tc qdisc del dev can0 root"));
  std::this_thread::sleep_for(milliseconds(300));
  const json result = bench.stop_and_report(1);
  for (const json& axis : result.at("axes")) EXPECT_EQ(axis.at("fault"), "commands late");
  bench.start_controller({"--clear-faults"});
  EXPECT_TRUE(bench.tracks()) << bench.controller->err();
}

}  // namespace
}  // namespace hystcan::kvaser_hostile_test
