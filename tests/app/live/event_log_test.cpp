// The log lines about emergencies, including those of a node that sends one in every cycle.
#include "app/live/state_log.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "app/live/report.h"
#include "tests/support/shows.h"

namespace hystcan::app::event_log_test {
namespace {

constexpr const char* in_words = "node 1: emergency 0x5000: device hardware (error register 0x01)";

class EventLogOfAnAxis : public testing::Test {
 protected:
  void add(double time_s, std::optional<std::uint16_t> code, std::uint32_t times = 1) {
    controller::CycleRecord record;
    record.time_s = time_s;
    if (code)
      record.event = controller::NodeEvent{
          .node = 1, .emergency = {.code = *code, .error_register = 1, .manufacturer = {}}, .times = times};
    log.add("x", record);
  }
  /// One emergency per cycle of 1 ms, from 1 s on.
  void flood(int cycles) {
    for (int i = 0; i < cycles; ++i) add(1.0 + 1e-3 * i, 0x5000);
  }

  std::vector<std::string> lines;
  EventLog log{[this](can::BusHealthLog::Level, const std::string& line) { lines.push_back(line); }};
};

TEST_F(EventLogOfAnAxis, LogsAnEmergencyAtOnce) {
  add(1.25, 0x5000);
  EXPECT_EQ(lines, std::vector<std::string>{std::string("x: at 1.250 s ") + in_words});
  EXPECT_EQ(log.lines(), lines);
}

TEST_F(EventLogOfAnAxis, LogsAFloodOncePerSecondWithItsCount) {
  shows("S-143");
  flood(3500);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0], std::string("x: at 1.000 s ") + in_words);
  EXPECT_EQ(lines[1], std::string("x: ") + in_words + ", 1000 more times in 1.0 s");
}

TEST_F(EventLogOfAnAxis, LogsTheCountAfterTheFloodHasEnded) {
  flood(500);
  add(2.5, std::nullopt);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[1], std::string("x: ") + in_words + ", 499 more times in 1.5 s");
}

TEST_F(EventLogOfAnAxis, CountsEmergenciesOfTheSameCycle) {
  add(1.0, 0x5000, 7);
  add(2.5, std::nullopt);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NE(lines[1].find(", 6 more times"), std::string::npos) << lines[1];
}

TEST_F(EventLogOfAnAxis, KeepsOneEntryForAFloodWithItsTotal) {
  flood(3500);
  EXPECT_EQ(log.lines(), std::vector<std::string>{std::string("x: at 1.000 s ") + in_words +
                                                  ", 3500 times until 4.499 s"});
  EXPECT_EQ(log.truncated(), 0u);
}

TEST_F(EventLogOfAnAxis, HasTheTimeOfEachRareEmergency) {
  add(1.0, 0x5000);
  add(3.0, 0x5000);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[1], std::string("x: at 3.000 s ") + in_words);
}

TEST_F(EventLogOfAnAxis, CountsTheEventsBeyondAHundredKinds) {
  for (std::uint16_t i = 0; i < 105; ++i) add(1.0, 0x5000 + i);
  add(1.0, 0x6000, 10);
  EXPECT_EQ(log.lines().size(), EventLog::most_kinds);
  EXPECT_EQ(log.truncated(), 15u);
  EXPECT_EQ(lines.size(), EventLog::most_kinds + 1);
}

TEST(BusClosing, ReportsTheNumberOfOmittedEvents) {
  EXPECT_EQ(describe(BusClosing{.events_truncated = 15})[0],
            "15 events are not shown, because there were too many kinds of events");
}

}  // namespace
}  // namespace hystcan::app::event_log_test
