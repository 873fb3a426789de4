#include "config/schema/bus_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "config/schema/wiring.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::bus_plan_test {
namespace {

using namespace std::chrono_literals;

Config shipped(const char* name) { return load(std::string(HYSTCAN_SOURCE_DIR "/config/") + name); }

const PlannedFrame& planned(const BusPlan& plan, const std::string& name) {
  return *std::ranges::find(plan.frames, name, [](const PlannedFrame& p) { return p.frame.name; });
}

TEST(BusPlan, FitsTheShippedStageAndMatchesAManualCount) {
  const BusPlan plan = plan_bus(shipped("piezo.toml"));
  EXPECT_EQ(plan.frames.size(), 14U);
  EXPECT_EQ(plan.emergencies.size(), 4U);
  // The SYNC follows a full cycle (655 with turnaround) with both amplifiers' statuses (270), all five
  // heartbeats (325) and one of the controller's axis statuses (135); the controller's frames precede this
  // SYNC in its queue.
  EXPECT_EQ(planned(plan, "Sync").response, 655us + 270us + 325us + 135us + 65us - 1000us);
  // SYNC, sample, command: 65 + 135 + 135; turnaround 50; the other axis's sample and command 270; both
  // statuses 270; a heartbeat of 65 bits before each of the three.
  EXPECT_EQ(planned(plan, "YAmpCommand").response, 335us + 50us + 270us + 270us + 195us);
  EXPECT_EQ(planned(plan, "YAmpCommand").deadline, 1135us);
  EXPECT_TRUE(plan.commands_in_time());
  for (const PlannedFrame& frame : plan.frames) EXPECT_TRUE(frame.in_time()) << frame.frame.name;
  // 65 + 4 * 135 bits in each of 1000 cycles, two statuses in every tenth, five heartbeats and two axis
  // statuses in 100 ms.
  EXPECT_NEAR(plan.load, (605.0 * 1000 + 2 * 135 * 100 + (5 * 65 + 2 * 135) * 10) / 1e6, 1e-9);
  EXPECT_LT(plan.load, 2.0 / 3.0);
}

// A frame of any node may be on the bus when a sample or a command is queued: here two live setpoints of 135
// bits instead of two heartbeats of 65.
TEST(BusPlan, CountsTheLiveSetpointsOfOtherNodes) {
  Config config = shipped("piezo.toml");
  config.controller.rate_Hz = 800.0;
  const can::Duration before = *plan_bus(config).last_command;
  for (AxisConfig& axis : config.axes) axis.live_setpoint = true;
  const BusPlan plan = plan_bus(config);
  EXPECT_EQ(plan.frames.size(), 16U);
  EXPECT_EQ(*plan.last_command, before + 140us);
  EXPECT_TRUE(plan.commands_in_time());
  config.controller.rate_Hz = 1000.0;
  EXPECT_FALSE(plan_bus(config).commands_in_time()) << "two axes leave no room for them at 1 Mbit/s";
}

// The statuses of all axes take turns, one per cycle: more axes do not cause more statuses in a cycle.
TEST(BusPlan, DelaysNoCommandByTheControllersStatuses) {
  Config config = shipped("piezo.toml");
  const can::Duration with = *plan_bus(config).last_command;
  std::erase_if(config.database.messages,
                [](const can::Message& message) { return message.name.ends_with("ControllerStatus"); });
  EXPECT_EQ(plan_bus(config).frames.size(), 12U);
  EXPECT_EQ(*plan_bus(config).last_command, with);
}

TEST(BusPlan, HasSpareTimeForOneAxis) {
  const BusPlan plan = plan_bus(shipped("galfenol.toml"));
  EXPECT_LT(*plan.last_command, 600us);
}

TEST(BusPlan, ReportsAnOverloadedBus) {
  Config config = shipped("piezo.toml");
  config.bus.bitrate_bit_per_s = 250'000;
  const BusPlan plan = plan_bus(config);
  EXPECT_GT(plan.load, 1.0);
  EXPECT_FALSE(plan.last_command);
  EXPECT_FALSE(plan.commands_in_time());
}

void expect_refused(const char* what, const char* with, const std::string& line, const std::string& message) {
  const support::ShippedCopy copy;
  copy.edit("piezo.toml", what, with);
  const std::string refusal = support::refusal_of([&] { load(copy / "piezo.toml"); });
  EXPECT_NE(refusal.find(":" + line + ":"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find(message), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("Hz fits), raise bus.bitrate_bit_per_s, or drive fewer axes than now"),
            std::string::npos)
      << refusal;
}

TEST(BusPlan, RefusesLateCommandsAtTheRate) {
  expect_refused("1_000_000", "800_000", "16", "the last command may start");
  expect_refused("1_000_000", "125_000", "16", "the bus is loaded to 510 % of 125000 bit/s");
  expect_refused("\"hystcan.dbc\"", "\"hystcan.dbc\"\nturnaround_us = 100.0", "17",
                 "expected within the cycle");
}

TEST(BusPlan, HasEachFrameAndEachNodeOnceThatAxesShare) {
  const BusPlan plan = plan_bus(shipped("fd_stage.toml"));
  std::vector<std::string> names;
  for (const PlannedFrame& each : plan.frames) names.push_back(each.frame.name);
  EXPECT_EQ(names, (std::vector<std::string>{"Sync", "Samples", "Statuses", "Commands", "SensorHeartbeat",
                                             "AmpHeartbeat", "ControllerHeartbeat"}));
  EXPECT_EQ(plan.emergencies.size(), 2U);
}

TEST(Wiring, EqualsTheShippedStageForTwoClassicalAxes) {
  const Config stage = shipped("piezo.toml");
  const BusPlan plan = plan_bus(wired_as(Wiring::classical, 2, stage));
  EXPECT_EQ(plan.last_command, plan_bus(stage).last_command);
  EXPECT_DOUBLE_EQ(plan.load, plan_bus(stage).load);
}

TEST(Wiring, MatchesAManualCountForSharedFrames) {
  const auto last_command = [](std::size_t axes, double rate_Hz) {
    Config config = wired_as(Wiring::fd_shared, axes, shipped("piezo.toml"));
    config.controller.rate_Hz = rate_Hz;
    return plan_bus(config).last_command;
  };
  // SYNC 65, turnaround 50; sample and status of 10 bytes in frames of 12, 32 + 154 / 5; two heartbeats, 130.
  EXPECT_EQ(last_command(2, 2500.0), 65us + 50us + 2 * 62'800ns + 130us);
  // 28 bytes in frames of 32: 32 + 359 / 5.
  EXPECT_EQ(last_command(8, 2000.0), 65us + 50us + 2 * 103'800ns + 130us);
}

TEST(Wiring, HasOneBackgroundFramePerCycleWithSlots) {
  Config config = wired_as(Wiring::fd_slots, 2, shipped("piezo.toml"));
  config.controller.rate_Hz = 4000.0;
  EXPECT_EQ(plan_bus(config).last_command, 65us + 50us + 62'800ns + 65us);
}

TEST(Wiring, LeavesOutTheNodeOfTheController) {
  Config config = shipped("piezo.toml");
  config.controller.node = 3;
  EXPECT_EQ(plan_bus(wired_as(Wiring::classical, 16, config)).frames.size(), 16U * 6 + 2);
}

TEST(FastestRate, IsTheLastStepThatFits) {
  for (const Wiring wiring : {Wiring::classical, Wiring::fd, Wiring::fd_shared, Wiring::fd_slots}) {
    Config config = wired_as(wiring, 3, shipped("piezo.toml"));
    config.controller.rate_Hz = rate_max_Hz;
    const double fastest_Hz = fastest_rate_Hz(config);
    EXPECT_EQ(std::fmod(fastest_Hz, 10.0), 0.0);
    config.controller.rate_Hz = fastest_Hz;
    EXPECT_TRUE(plan_bus(config).commands_in_time()) << fastest_Hz;
    config.controller.rate_Hz = fastest_Hz + 10.0;
    EXPECT_FALSE(plan_bus(config).commands_in_time()) << fastest_Hz;
  }
}

TEST(FastestRate, IsTheConfiguredRateIfItFits) {
  EXPECT_EQ(fastest_rate_Hz(shipped("galfenol.toml")), 1000.0);
}

}  // namespace
}  // namespace hystcan::config::bus_plan_test
