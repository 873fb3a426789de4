// hystcan ctl with a controller that drives the axes on vcan0: its answers and the effect on the wire.
#include <gtest/gtest.h>

#include "tests/hil/live_stage.h"

namespace hystcan::ctl_test {
namespace {

using hil::json;
using hil::QuickStage;

constexpr std::size_t x = 0;
constexpr std::size_t y = 1;

struct Ctl : testing::Test {
  QuickStage stage;

  /// Starts and waits until both axes track.
  void start() { stage.start(); }
  void expect_done(const std::vector<std::string>& words) const {
    const QuickStage::Answer answer = stage.ctl(words);
    EXPECT_EQ(answer.status, 0) << testing::PrintToString(words) << answer.err;
  }
  void expect_refused(const std::vector<std::string>& words, const std::string& reason) const {
    const QuickStage::Answer answer = stage.ctl(words);
    EXPECT_NE(answer.status, 0) << testing::PrintToString(words);
    EXPECT_NE(answer.err.find(reason), std::string::npos) << testing::PrintToString(words) << answer.err;
  }
};

TEST_F(Ctl, WatchRepeatsTheStatusUntilItIsInterrupted) {
  start();
  support::Process watch(
      {HYSTCAN_PROGRAM, "status", "--watch", "--interface", "vcan0", "--socket", stage.socket});
  for (const char* part : {"bus vcan0: up", "SYNC late", "nodes: ", "tracking"})
    EXPECT_TRUE(hil::eventually([&] { return watch.out().find(part) != std::string::npos; })) << part;
  watch.send(SIGINT);
  EXPECT_EQ(watch.wait(), 0) << watch.err();
}

TEST_F(Ctl, ReportsAFaultWithItsRemedyAndRestartsTheAxis) {
  start();
  ASSERT_TRUE(hil::shell("cansend vcan0 000#0201")) << "another node stops node 1 by NMT";
  ASSERT_TRUE(stage.reaches(x, "faulted"));
  const json status = stage.axis_status(x);
  EXPECT_NE(status.at("fault"), "none");
  EXPECT_FALSE(status.at("remedy").get<std::string>().empty());
  const QuickStage::Answer table = stage.ctl({"status"});
  EXPECT_NE(table.out.find(status.at("remedy").get<std::string>()), std::string::npos) << table.out;
  std::printf("x: %s; %s\n", status.at("fault").get<std::string>().c_str(),
              status.at("remedy").get<std::string>().c_str());
  expect_refused({"enable", "x"}, "clear the fault first");
  expect_refused({"wait", "x"}, "faulted");
  expect_done({"clear", "x"});
  ASSERT_TRUE(stage.reaches(x, "offline"));
  expect_done({"enable", "x"});
  ASSERT_TRUE(stage.reaches(x, "tracking")) << stage.bench.controller->err();
  EXPECT_EQ(stage.axis_status(y).at("state"), "tracking");
  expect_done({"stop"});
  EXPECT_EQ(stage.bench.controller->wait(), 0) << "a cleared fault does not change the exit status";
}

}  // namespace
}  // namespace hystcan::ctl_test
