// The log lines about the states of the axes.
#include "app/live/state_log.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace hystcan::app::state_log_test {
namespace {

using controller::ArmingBlock;
using controller::ArmingBlocks;
using controller::AxisState;

/// The shipped two-axis stage; axis 0 is x.
class StateLogOfTwoAxes : public testing::Test {
 protected:
  void add(std::size_t axis, double time_s, AxisState state, ArmingBlocks blocks = {}) {
    controller::CycleRecord record;
    record.time_s = time_s;
    record.axis = axis;
    record.report.state = state;
    record.report.arming_blocks = blocks;
    log.add(record);
  }
  std::vector<std::string> lines;
  std::vector<can::BusHealthLog::Level> levels;
  StateLog log{config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml"),
               [this](can::BusHealthLog::Level level, const std::string& line) {
                 levels.push_back(level);
                 lines.push_back(line);
               }};
};

TEST_F(StateLogOfTwoAxes, LogsOnceAfterTwoSecondsWhyAnAxisWaits) {
  for (int i = 0; i < 10; ++i) add(0, 0.5 * i, AxisState::waiting, ArmingBlock::sensor_heartbeat);
  const std::vector<std::string> expected{"x: waiting for amplifier node 1 and sensor node 2",
                                          "x: still waits for a heartbeat of the sensor (node 2)"};
  EXPECT_EQ(lines, expected);
}

TEST_F(StateLogOfTwoAxes, ListsAllReasonsOfAWaitingAxis) {
  ArmingBlocks blocks = ArmingBlock::amplifier_heartbeat;
  blocks.add(ArmingBlock::sensor_operational);
  for (const double time_s : {0.0, 2.5}) add(0, time_s, AxisState::waiting, blocks);
  EXPECT_EQ(
      lines.back(),
      "x: still waits for a heartbeat of the amplifier (node 1); the sensor to be operational (node 2)");
}

TEST_F(StateLogOfTwoAxes, LogsTheFirstReasonEvenIfTheOthersChange) {
  for (int i = 0; i < 10; ++i) {
    ArmingBlocks blocks = ArmingBlock::amplifier_ready;
    if (i % 2 == 1) blocks.add(ArmingBlock::sample);
    add(0, 0.5 * i, AxisState::waiting, blocks);
  }
  EXPECT_EQ(lines.size(), 2U);
}

TEST_F(StateLogOfTwoAxes, DoesNotLogAReasonThatIsBrief) {
  add(0, 0.0, AxisState::waiting, ArmingBlock::sensor_heartbeat);
  add(0, 1.9, AxisState::waiting, ArmingBlock::sample);
  add(0, 3.8, AxisState::waiting, ArmingBlock::amplifier_rest);
  EXPECT_EQ(lines.size(), 1u);
}

TEST_F(StateLogOfTwoAxes, NamesTheAxisWithoutWhichTheOthersBegin) {
  add(1, 0.0, AxisState::waiting, ArmingBlock::amplifier_ready);
  add(0, 0.0, AxisState::tracking);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(
      lines.back(),
      "y: not ready, waits for an amplifier status that says ready (node 3); the other axes start without "
      "it");
}

TEST_F(StateLogOfTwoAxes, NamesTheAxesThatAReadyAxisWaitsFor) {
  add(1, 0.0, AxisState::waiting, ArmingBlock::sensor_heartbeat);
  for (const double time_s : {0.0, 2.5}) add(0, time_s, AxisState::ready, ArmingBlock::other_axes);
  EXPECT_EQ(lines.back(), "x: still waits for the other axes: y");
}

TEST_F(StateLogOfTwoAxes, LogsAnOutputOutOfRangeWithItsValue) {
  for (const double time_s : {0.0, 2.5}) {
    controller::CycleRecord record;
    record.time_s = time_s;
    record.amplifier_output = 120.0;
    record.report.state = AxisState::waiting;
    record.report.arming_blocks = ArmingBlock::amplifier_output;
    log.add(record);
  }
  EXPECT_EQ(lines.back(),
            "x: still waits for an amplifier output within drive_min..drive_max (node 1): the output is 120, "
            "expected 0 to 100 V");
}

TEST_F(StateLogOfTwoAxes, LogsTheVerificationOfTheWatchdog) {
  controller::CycleRecord record;
  record.report.watchdog_tripped_after_s = 0.021;
  log.add(record);
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.front(), "x: watchdog of the amplifier (node 1) verified: tripped after 21 ms");
}

TEST_F(StateLogOfTwoAxes, LogsAnErrorResetAsInformation) {
  for (const std::uint16_t code : std::initializer_list<std::uint16_t>{0x8130, 0x0000}) {
    controller::CycleRecord record;
    controller::NodeEvent event;
    event.emergency.code = code;
    record.event = event;
    log.add(record);
  }
  using Level = can::BusHealthLog::Level;
  EXPECT_EQ(levels, (std::vector{Level::warning, Level::info}));
}

/// The axes of fd_stage.toml, whose nodes are 8 (sensor) and 16 (amplifier), report the same frames.
class StateLogOfAxesThatShareNodes : public testing::Test {
 protected:
  void add(std::size_t axis, double time_s, const controller::NodeEvent& event) {
    controller::CycleRecord record;
    record.time_s = time_s;
    record.axis = axis;
    record.event = event;
    log.add(record);
  }
  std::vector<std::string> lines;
  StateLog log{config::load(HYSTCAN_SOURCE_DIR "/config/fd_stage.toml"),
               [this](can::BusHealthLog::Level, const std::string& line) { lines.push_back(line); }};
};

TEST_F(StateLogOfAxesThatShareNodes, LogsAnEmergencyOnceWithBothNames) {
  const controller::NodeEvent emergency{.node = 16, .emergency = {.code = 0x8130, .manufacturer = {}}};
  for (const std::size_t axis : {0, 1}) add(axis, 1.0, emergency);
  const std::vector<std::string> expected{
      "x, y: at 1.000 s node 16: emergency 0x8130: life guard or heartbeat error (error register 0x00)"};
  EXPECT_EQ(lines, expected);
  EXPECT_EQ(log.events().lines(), expected) << "counted once too";
}

TEST_F(StateLogOfAxesThatShareNodes, LogsAForeignFrameOnceForBothAxes) {
  const controller::NodeEvent foreign{.kind = controller::NodeEvent::Kind::another_controller,
                                      .frame = {.id = 0x080}};
  add(1, 1.000, foreign);
  add(0, 1.001, foreign);
  EXPECT_EQ(lines, std::vector<std::string>{"x, y: at 1.000 s another node sends SYNC (0x080)"});
  add(0, 8.0, foreign);
  EXPECT_EQ(lines.size(), 2U) << "of another fault";
}

TEST_F(StateLogOfTwoAxes, LogsTheSameEmergencyOfTwoNodesForEachAxis) {
  for (const std::size_t axis : {0, 1}) {
    controller::CycleRecord record;
    record.axis = axis;
    record.event = controller::NodeEvent{.node = static_cast<std::uint8_t>(1 + 2 * axis),
                                         .emergency = {.code = 0x8130, .manufacturer = {}}};
    log.add(record);
  }
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_TRUE(lines[0].starts_with("x: at ") && lines[1].starts_with("y: at "));
}

TEST_F(StateLogOfTwoAxes, ReportsWhetherAnAxisWasTracked) {
  add(0, 0.0, AxisState::waiting, ArmingBlock::sample);
  add(0, 0.1, AxisState::initialising);
  add(1, 0.1, AxisState::waiting, ArmingBlock::sample);
  EXPECT_FALSE(log.has_any_tracked());
  EXPECT_EQ(log.blocks_of(0), "x waited for a sample (node 2)");
  add(0, 0.2, AxisState::tracking);
  EXPECT_TRUE(log.has_any_tracked());
  EXPECT_TRUE(log.has_tracked(0));
  EXPECT_FALSE(log.has_tracked(1));
  EXPECT_EQ(log.blocks_of(1), "y waited for a sample (node 4)");
}

}  // namespace
}  // namespace hystcan::app::state_log_test
