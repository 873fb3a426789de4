// Two SJA1000 controllers with their real driver on one wire, while the axes track.
//
// QEMU's model of them always acknowledges and has no errors of the wire: it sets no status bit except the
// receive overrun, error counters and bit timing read 0, and nodes with different bit rates understand each
// other. Therefore the driver's own bus-off cannot occur here. Error frames as canerrsim writes them replace
// it; tests/can/socketcan/serial_adapter_test.cpp tests what a driver in bus-off does.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

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

TEST_F(KvaserHostile, TheLinkDownAndUpFaultsBothAxesAndANewStartTracks) {
  EXPECT_TRUE(bench.controller->says("can0: 1000 kbit/s")) << bench.controller->err();
  ASSERT_TRUE(shell("ip link set can0 down"));
  EXPECT_TRUE(bench.controller->says("x: faulted")) << bench.controller->err();
  ASSERT_TRUE(shell("ip link set can0 up"));
  EXPECT_TRUE(bench.controller->says("can0: bus active at")) << bench.controller->err();
  EXPECT_EQ(bench.stop_and_report(1).at("axes")[0].at("fault"), "interface down");
  bench.start_controller({"--clear-faults"});
  EXPECT_TRUE(bench.tracks()) << bench.controller->err();
}

// 50 ms later the driver reports that it is not in bus-off. The bus-off therefore ends without a restart
// frame; the axes stay disarmed.
TEST_F(KvaserHostile, BusOffDisarmsAlsoWhenTheDriverDeniesIt) {
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

// The controller sends three frames each millisecond. One frame in 8 ms goes out and two may wait: the kernel
// refuses the rest (ENOBUFS), as on a bus that another node occupies.
TEST_F(KvaserHostile, AFullTransmitQueueFaultsWithACauseAndANewStartTracks) {
  shows("S-166");
  ASSERT_TRUE(shell("tc qdisc replace dev can0 root tbf rate 16kbit burst 20 limit 32"));
  EXPECT_TRUE(bench.controller->says("x: faulted")) << bench.controller->err();
  EXPECT_TRUE(bench.controller->says("y: faulted")) << bench.controller->err();
  ASSERT_TRUE(shell("tc qdisc del dev can0 root"));
  std::this_thread::sleep_for(milliseconds(300));
  const json result = bench.stop_and_report(1);
  for (const json& axis : result.at("axes")) {
    EXPECT_NE(axis.at("fault"), "none");
    std::printf("axis %s: %s\n", std::string(axis.at("name")).c_str(), std::string(axis.at("fault")).c_str());
  }
  EXPECT_GT(result.at("bus").at("send_refused"), 0);
  EXPECT_EQ(result.at("bus").at("state"), "active") << "a full queue is no fault of the bus";
  bench.start_controller({"--clear-faults"});
  EXPECT_TRUE(bench.tracks()) << bench.controller->err();
}

// The queue takes every frame and lets one out in 8 ms, as behind a bus that others fill. Its driver echoes a
// frame when it has left: the commands are seen to be late before samples are missing.
TEST_F(KvaserHostile, CommandsThatWaitInTheQueueFaultAsLate) {
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

struct Command {
  std::string axis;
  double setpoint;
};
/// The commands with Enable of a candump log that come more than three cycles of 1 ms after the SYNC that
/// they name.
std::vector<Command> old_commands(const std::string& log) {
  std::map<int, double> syncs;
  std::vector<Command> old;
  std::istringstream lines(log);
  for (std::string time, interface, frame; lines >> time >> interface >> frame;) {
    const double time_s = std::stod(time.substr(1));
    const auto byte = [&](std::size_t i) { return std::stoi(frame.substr(4 + 2 * i, 2), nullptr, 16); };
    if (frame.starts_with("080#")) syncs[byte(0)] = time_s;
    if (!frame.starts_with("201#") && !frame.starts_with("203#")) continue;
    const bool enables = (byte(4) & 1) != 0;
    if (!enables || time_s - syncs[byte(5)] < 0.003) continue;
    const int raw = byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24;
    old.push_back({frame.starts_with("201#") ? "x" : "y", 1e-6 * raw});
  }
  return old;
}

/// How often the amplifier of the axis had this setpoint at a sample.
int times_applied(const std::string& truth, const Command& command) {
  std::istringstream lines(truth);
  int times = 0;
  for (std::string line; std::getline(lines, line);) {  // time_s,axis,sync_counter,setpoint,...
    std::istringstream fields(line);
    std::string time, axis, counter, setpoint;
    std::getline(fields, time, ',') && std::getline(fields, axis, ',') &&
        std::getline(fields, counter, ',') && std::getline(fields, setpoint, ',');
    if (axis == command.axis && std::abs(std::stod(setpoint) - command.setpoint) < 5e-7) ++times;
  }
  return times;
}

// Behind the dam every command waits in front of the next SYNC, so that its counter is still the last one.
// The watchdogs wait for 20 ms, the second axis's command for 8 ms.
TEST(KvaserOldCommand, LeavesTheQueueOfTheDriverAndIsNotApplied) {
  const std::string truth = testing::TempDir() + "old_command_truth.csv";
  LiveBench bench{{"can0", "can1"}, hil::config_file, hil::Nodes::of_the_test};
  bench.start_twin({"--truth", truth});
  bench.start_controller({"--json"});
  ASSERT_TRUE(bench.tracks()) << bench.controller->err();
  std::this_thread::sleep_for(milliseconds(300));
  const bool is_dammed = shell("tc qdisc replace dev can0 root tbf rate 16kbit burst 20 limit 3200");
  EXPECT_TRUE(bench.controller->says("y: faulted")) << bench.controller->err();
  ASSERT_TRUE(shell("tc qdisc del dev can0 root"));
  ASSERT_TRUE(is_dammed);
  std::this_thread::sleep_for(milliseconds(300));
  bench.stop_and_report(1);
  bench.twin->send(SIGTERM);
  EXPECT_EQ(bench.twin->wait(), 0) << bench.twin->err();
  const std::vector<Command> old = old_commands(bench.log());
  ASSERT_FALSE(old.empty());
  const std::string rows = support::read_file(truth);
  ASSERT_NE(rows.find(",y,"), std::string::npos);
  for (const Command& command : old) EXPECT_EQ(times_applied(rows, command), 0) << command.axis;
}

}  // namespace
}  // namespace hystcan::kvaser_hostile_test
