#include "app/command_line/status_text.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hystcan::app::status_text_test {
namespace {

StatusAnswer status() {
  return {.time_s = 12.3,
          .age_s = 0.01,
          .counters = {.cycles = 12345, .missed_cycles = 1, .missing_samples = 2},
          .timing = {.period_us = 1000.0, .lateness_us = 2.1, .turnaround_us = 31.5, .execution_us = 1.2},
          .axes = {{.name = "x",
                    .state = controller::AxisState::tracking,
                    .limits = "slew",
                    .reference_um = 14.2128,
                    .arrival = controller::Arrival::moving},
                   {.name = "y",
                    .state = controller::AxisState::faulted,
                    .fault = "sensor silent",
                    .fault_time_s = 3.5,
                    .remedy = "look at its cable"}}};
}

const BusReport bus{"can0", "up", 4000.0, 38.24};

bool has(const std::vector<std::string>& lines, const std::string& text) {
  return std::ranges::any_of(lines, [&](const auto& line) { return line.find(text) != std::string::npos; });
}

TEST(StatusScreen, HasBusTimingNodesAndARowForEachAxis) {
  const auto lines = status_screen(status(), bus, "");
  EXPECT_TRUE(has(lines, "bus can0: up, 4000 frames/s, load 38.2 %"));
  EXPECT_TRUE(has(lines, "SYNC late 2.1 us, sample to command 31.5 us"));
  EXPECT_TRUE(has(lines, "nodes: no event yet"));
  EXPECT_TRUE(has(lines, "12345 cycles, 1 missed, 2 samples missing"));
  EXPECT_TRUE(has(lines, "moving limited by slew"));
  EXPECT_TRUE(has(lines, "sensor silent at 3.500 s; look at its cable"));
}

TEST(StatusScreen, ShowsTheLastEventOfANode) {
  StatusAnswer with_event = status();
  with_event.last_event = {.text = "node 1: emergency 0x8130", .time_s = 3.25};
  EXPECT_TRUE(has(status_screen(with_event, bus, ""), "nodes: node 1: emergency 0x8130, 3.2 s"));
}

TEST(StatusScreen, ListsEverythingThatAnAxisWaitsFor) {
  StatusAnswer waiting = status();
  waiting.axes[1].state = controller::AxisState::waiting;
  waiting.axes[1].waits_for_all = {"a heartbeat of the sensor", "a heartbeat of the amplifier"};
  EXPECT_TRUE(has(status_screen(waiting, bus, ""),
                  "waits for a heartbeat of the sensor; a heartbeat of the amplifier"));
}

TEST(StatusScreen, ShowsTheBusIfThereIsNoAnswer) {
  const auto lines = status_screen({}, bus, "no answer, trying again: no such file");
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines.front(), "no answer, trying again: no such file");
}

}  // namespace
}  // namespace hystcan::app::status_text_test
