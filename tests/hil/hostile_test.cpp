// Typical disturbances of a laboratory bus while the axes track, on real SocketCAN: the interface goes down
// or disappears, the CAN controller goes bus-off, another node floods the bus.
#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "tests/hil/live_stage.h"
#include "tests/support/shows.h"

namespace hystcan::hostile_test {
namespace {

using hil::json;
using hil::LiveBench;
using hil::milliseconds;
using hil::shell;

struct VcanHostile : testing::Test {
  void SetUp() override {
    bench.start_controller({"--json"});
    ASSERT_TRUE(bench.tracks()) << bench.controller->err();
  }
  hil::QuickStage stage;
  LiveBench& bench = stage.bench;
};

TEST_F(VcanHostile, LinkDownAndUpFaultsBothAxesAndArmsNothing) {
  shows("S-165");
  ASSERT_TRUE(shell("ip link set vcan0 down"));
  EXPECT_TRUE(bench.controller->says("x: faulted")) << bench.controller->err();
  EXPECT_TRUE(bench.controller->says("vcan0: bus down at")) << bench.controller->err();
  ASSERT_TRUE(shell("ip link set vcan0 up"));
  EXPECT_TRUE(bench.controller->says("vcan0: bus active at")) << bench.controller->err();
  std::this_thread::sleep_for(milliseconds(300));
  const json result = bench.stop_and_report(1);
  for (const json& axis : result.at("axes")) {
    EXPECT_EQ(axis.at("fault"), "interface down");
    EXPECT_EQ(axis.at("state"), "faulted");
  }
  EXPECT_EQ(result.at("bus").at("state"), "active");
  EXPECT_GT(result.at("bus").at("send_refused"), 0);
}

// The bytes that canerrsim of can-utils writes for bus-off and for a restart.
TEST_F(VcanHostile, BusOffDisarmsAtOnceAndOnlyANewStartArmsAgain) {
  shows("S-012");
  ASSERT_TRUE(shell("cansend vcan0 20000040#0000000000000000"));
  EXPECT_TRUE(bench.controller->says("x: faulted")) << bench.controller->err();
  EXPECT_TRUE(bench.controller->says("vcan0: bus bus-off at")) << bench.controller->err();
  ASSERT_TRUE(shell("cansend vcan0 20000100#0000000000000000"));
  EXPECT_TRUE(bench.controller->says("1 restarts after bus-off")) << bench.controller->err();
  std::this_thread::sleep_for(milliseconds(300));
  const json result = bench.stop_and_report(1);
  for (const json& axis : result.at("axes")) EXPECT_EQ(axis.at("fault"), "bus-off");
  EXPECT_EQ(result.at("bus").at("bus_offs"), 1);
  EXPECT_EQ(result.at("bus").at("restarts"), 1);
  bench.start_controller({"--clear-faults"});
  EXPECT_TRUE(bench.tracks()) << bench.controller->err();
}

// The flood contains every identifier, length and kind of frame at the highest rate, including NMT commands,
// SYNCs and the stage's own identifiers. The axes keep tracking or fault with a cause; the amplifiers are
// safe at the end.
TEST_F(VcanHostile, AFloodOfFramesIsBridgedOrFaultsTheAxes) {
  ASSERT_TRUE(shell("cangen vcan0 -g 0 -I i -L i -D i -m -n 40000"));
  std::this_thread::sleep_for(milliseconds(300));
  ASSERT_TRUE(bench.controller->running()) << bench.controller->err();
  bench.controller->send(SIGTERM);
  const int status = bench.controller->wait();
  const json result = json::parse(bench.controller->out());
  std::printf("after 40000 frames: %s; bus %s\n", bench.controller->err().c_str(),
              result.at("bus").dump().c_str());
  for (const json& axis : result.at("axes")) {
    const json& rejected = axis.at("rejected_samples");
    std::printf("axis %s: %s, rejected samples %s\n", std::string(axis.at("name")).c_str(),
                std::string(axis.at("fault")).c_str(), rejected.dump().c_str());
    int frames = 0;
    for (const auto& [cause, count] : rejected.items()) frames += static_cast<int>(count);
    EXPECT_GT(frames, 0) << "cangen sends every identifier some times";
    EXPECT_TRUE(axis.at("fault") != "none" || axis.at("rms_percent") < 1.0) << axis.dump(2);
  }
  for (const char* message : {"XAmpStatus", "heartbeat of node 2"}) {
    int frames = 0;
    for (const auto& [cause, count] : result.at("bus").at("rejected").at(message).items())
      frames += static_cast<int>(count);
    EXPECT_GT(frames, 0) << message;
  }
  EXPECT_TRUE(status == 0 || status == 1) << status;
  std::this_thread::sleep_for(milliseconds(200));
  bench.twin->send(SIGINT);
  const bool ended_cleanly = bench.twin->wait() == 0;
  const std::string log = bench.twin->err();
  EXPECT_TRUE(ended_cleanly || log.find("is already on this bus") != std::string::npos)
      << "a frame may be a valid heartbeat of one of its nodes: " << log;
  EXPECT_NE(log.find("x: amplifier off, at its safe value 0.000"), std::string::npos) << log;
  EXPECT_NE(bench.twin->out().find("bus active: "), std::string::npos) << bench.twin->out();
  EXPECT_NE(bench.twin->out().find("XAmpCommand: rejected: "), std::string::npos) << bench.twin->out();
}

}  // namespace
}  // namespace hystcan::hostile_test
