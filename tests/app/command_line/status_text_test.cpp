#include "app/command_line/status_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace hystcan::app::status_text_test {
namespace {

using nlohmann::json;

json status() {
  return json::parse(R"({"ok": true, "time_s": 12.3, "age_s": 0.01, "cycles": 12345, "missed_cycles": 1,
    "missing_samples": 2, "late_samples": 0,
    "timing": {"period_us": 1000.0, "lateness_us": 2.1, "turnaround_us": 31.5, "execution_us": 1.2},
    "recording": {"on": false},
    "axes": [
      {"name": "x", "state": "tracking", "fault": "none", "position_um": 14.2131, "drive": 48.31,
       "amplifier_output": 48.29, "limits": "slew", "reference_um": 14.2128, "error_um": -0.0003, "arrival": "moving"},
      {"name": "y", "state": "faulted", "fault": "sensor silent", "fault_time_s": 3.5, "remedy": "look at its cable",
       "position_um": 5.0, "drive": 0.0, "limits": ""}]})");
}

const json bus{{"interface", "can0"}, {"state", "up"}, {"frames_per_s", 4000.0}, {"load_percent", 38.24}};

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
  json with_event = status();
  with_event["last_event"] = {{"text", "node 1: emergency 0x8130"}, {"time_s", 3.25}};
  EXPECT_TRUE(has(status_screen(with_event, bus, ""), "nodes: node 1: emergency 0x8130, 3.2 s"));
}

TEST(StatusScreen, NamesAllThatAnAxisWaitsFor) {
  json waiting = status();
  json& y = waiting["axes"][1];
  y["state"] = "waiting";
  y["waits_for"] = "a heartbeat of the sensor";
  y["waits_for_all"] = {"a heartbeat of the sensor", "a heartbeat of the amplifier"};
  EXPECT_TRUE(has(status_screen(waiting, bus, ""),
                  "waits for a heartbeat of the sensor; a heartbeat of the amplifier"));
}

TEST(StatusScreen, ShowsTheBusWhereNobodyAnswers) {
  const auto lines = status_screen(nullptr, bus, "no answer, trying again: no such file");
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines.front(), "no answer, trying again: no such file");
}

}  // namespace
}  // namespace hystcan::app::status_text_test
