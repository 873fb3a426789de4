// A node sends an emergency in every cycle, on real CAN.
#include <gtest/gtest.h>

#include <string>

#include "tests/hil/live_stage.h"
#include "tests/support/shows.h"

namespace hystcan::emergency_flood_test {
namespace {

TEST(EmergencyFlood, HasFewLinesInTheLogAndOneEntryInTheResults) {
  shows("S-143");
  hil::QuickStage stage;
  stage.start({"--json"});
  ASSERT_TRUE(hil::shell("cangen vcan0 -I 081 -L 8 -D 0050010000000000 -g 1 -n 500"));
  const hil::json results = stage.bench.stop_and_report(1);  // of the fault
  ASSERT_EQ(results.at("events").size(), 1u) << results.at("events");
  const std::string event = results.at("events").at(0);
  EXPECT_NE(event.find("node 1: emergency 0x5000"), std::string::npos) << event;
  EXPECT_NE(event.find(", 500 times until "), std::string::npos) << event;
  EXPECT_EQ(results.at("events_truncated"), 0);
  int lines = 0;
  const std::string log = stage.bench.controller->err();
  for (auto at = log.find("emergency 0x5000"); at != std::string::npos;
       at = log.find("emergency 0x5000", at + 1))
    ++lines;
  EXPECT_LT(lines, 50) << log;
}

}  // namespace
}  // namespace hystcan::emergency_flood_test
