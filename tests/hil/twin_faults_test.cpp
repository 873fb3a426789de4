// The twin's faults between two processes on vcan: a test injects them by the twin's own socket, and the
// controller reports the same causes as on the simulated bus (tests/safety/twin_fault_test.cpp).
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/hil/live_stage.h"

namespace hystcan::twin_faults_test {
namespace {

using hil::json;
using hil::QuickStage;

constexpr std::size_t x = 0;
constexpr std::size_t y = 1;

struct TwinFaults : testing::Test {
  QuickStage stage;

  json twin_status() const {
    const QuickStage::Answer answer = stage.ctl_twin({"--json", "status"});
    EXPECT_EQ(answer.status, 0) << answer.err;
    return answer.status == 0 ? json::parse(answer.out) : json();
  }
  void inject(const std::vector<std::string>& words) const {
    std::vector<std::string> command{"inject"};
    command.insert(command.end(), words.begin(), words.end());
    const QuickStage::Answer answer = stage.ctl_twin(command);
    EXPECT_EQ(answer.status, 0) << answer.err;
  }
};

TEST_F(TwinFaults, FaultTheAxisUntilTheyAreRemovedAndItIsCleared) {
  stage.start();
  for (const auto& [fault, cause] :
       {std::pair{"wrong_crc", "sample missing"}, std::pair{"amplifier_trip", "amplifier fault"}}) {
    inject({fault, "--axis", "x"});
    ASSERT_TRUE(stage.reaches(x, "faulted")) << fault;
    EXPECT_EQ(stage.axis_status(x).at("fault"), cause);
    EXPECT_EQ(stage.axis_status(y).at("state"), "tracking") << fault;
    EXPECT_TRUE(stage.bench.twin->says(std::string(fault) + " begins")) << stage.bench.twin->err();
    EXPECT_EQ(stage.ctl_twin({"remove"}).status, 0);
    EXPECT_TRUE(twin_status().at("faults").empty());
    ASSERT_EQ(stage.ctl({"clear", "x"}).status, 0);
    ASSERT_TRUE(stage.reaches(x, "offline"));
    ASSERT_EQ(stage.ctl({"enable", "x"}).status, 0);
    ASSERT_TRUE(stage.reaches(x, "tracking")) << fault;
  }
}

/// In the first half second after Enable, when a ramp that goes on would be a step at the stage.
TEST_F(TwinFaults, RelayThatBouncesAtAnyPhaseOfTheStartIsAFault) {
  stage.start();
  ASSERT_EQ(stage.ctl({"disable", "x"}).status, 0);
  for (int phase = 0; phase < 20; ++phase) {
    ASSERT_TRUE(stage.reaches(x, "offline")) << phase;
    ASSERT_EQ(stage.ctl({"enable", "x"}).status, 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(20 * phase));
    inject({"relay_opens", "--axis", "x", "--duration", "0.002"});
    ASSERT_TRUE(stage.reaches(x, "faulted")) << phase;
    EXPECT_EQ(stage.axis_status(x).at("fault"), "amplifier not enabled") << phase;
    ASSERT_EQ(stage.ctl({"clear", "x"}).status, 0);
  }
}

TEST_F(TwinFaults, AreRefusedInWordsAndTheTwinEndsOnStop) {
  EXPECT_NE(stage.ctl_twin({"inject", "late"}).err.find("\"axis\" is missing"), std::string::npos);
  EXPECT_NE(stage.ctl_twin({"inject", "late", "--axis", "z"}).err.find("there is no axis"),
            std::string::npos);
  EXPECT_EQ(stage.ctl_twin({"stop"}).status, 0);
  EXPECT_EQ(stage.bench.twin->wait(), 0) << stage.bench.twin->err();
}

}  // namespace
}  // namespace hystcan::twin_faults_test
