// The twin's faults between two processes on vcan: a test injects them by the twin's own socket, and the
// controller reports the same causes as on the simulated bus (tests/safety/twin_fault_test.cpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/hil/live_stage.h"

namespace hystcan::twin_faults_test {
namespace {

using hil::json;
using hil::milliseconds;
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
  /// Axis x faults with one of these causes and y keeps tracking. After `remove`, clear and enable x tracks
  /// again.
  void expect_fault_and_return(const std::vector<std::string>& words,
                               const std::vector<std::string>& causes) {
    inject(words);
    expect_fault_until_it_is_removed(words, causes);
  }
  /// The same, where the fault is there before the axis starts.
  void expect_no_start_and_return(const std::vector<std::string>& words, const std::string& cause) {
    ASSERT_EQ(stage.ctl({"disable", "x"}).status, 0);
    ASSERT_TRUE(stage.reaches(x, "offline"));
    inject(words);
    ASSERT_EQ(stage.ctl({"enable", "x"}).status, 0);
    expect_fault_until_it_is_removed(words, {cause});
  }
  void expect_fault_until_it_is_removed(const std::vector<std::string>& words,
                                        const std::vector<std::string>& causes) {
    ASSERT_TRUE(stage.reaches(x, "faulted")) << words.front();
    const std::string cause = stage.axis_status(x).at("fault");
    EXPECT_NE(std::ranges::find(causes, cause), causes.end()) << words.front() << ": " << cause;
    std::printf("%s: %s\n", words.front().c_str(), cause.c_str());
    EXPECT_EQ(stage.axis_status(y).at("state"), "tracking") << words.front();
    EXPECT_EQ(stage.ctl_twin({"remove"}).status, 0);
    EXPECT_TRUE(twin_status().at("faults").empty());
    ASSERT_EQ(stage.ctl({"clear", "x"}).status, 0);
    ASSERT_TRUE(stage.reaches(x, "offline"));
    ASSERT_EQ(stage.ctl({"enable", "x"}).status, 0);
    ASSERT_TRUE(stage.reaches(x, "tracking")) << words.front();
    // The status of an amplifier is judged after it has been enabled for half a second.
    std::this_thread::sleep_for(milliseconds(700));
  }
};

TEST_F(TwinFaults, OfTheSensorFaultTheAxisAndAreCleared) {
  stage.start();
  expect_fault_and_return({"no_reply", "--axis", "x"}, {"sample missing"});
  expect_fault_and_return({"wrong_crc", "--axis", "x"}, {"sample missing"});
  expect_fault_and_return({"late", "--axis", "x", "--value", "1"}, {"sample late", "sample missing"});
  expect_fault_and_return({"out_of_range", "--axis", "x"}, {"position implausible"});
  expect_fault_and_return({"no_heartbeat", "--axis", "x", "--node", "sensor"}, {"sensor silent"});
  EXPECT_TRUE(stage.bench.twin->says("sensor of x: no_heartbeat begins")) << stage.bench.twin->err();
}

TEST_F(TwinFaults, OfTheAmplifierFaultTheAxisAndAreCleared) {
  stage.start();
  expect_fault_and_return({"amplifier_trip", "--axis", "x", "--duration", "0.5"}, {"amplifier fault"});
  // On a fast triangle the following error may come before the watchdog, which takes 20 ms.
  expect_fault_and_return({"watchdog_trip", "--axis", "x", "--duration", "0.2"},
                          {"amplifier fault", "following error"});
  // Without its supply the output falls within a millisecond or two; the stage follows it.
  expect_fault_and_return({"node_reboot", "--axis", "x", "--node", "amplifier", "--duration", "0.003"},
                          {"node restarted", "amplifier not enabled", "position jumped",
                           "position implausible", "following error"});
}

TEST_F(TwinFaults, OfASensorOrAnAmplifierThatIsNotWhatTheModelSaysEndTheStartUp) {
  stage.edit_both_axes("wipe_slew_V_per_s  = 2_000.0", "wipe_slew_V_per_s  = 500.0");  // as shipped
  stage.start();
  expect_no_start_and_return({"sensor_gain", "--axis", "x", "--value", "-1"}, "position contradicts drive");
  expect_no_start_and_return({"sensor_gain", "--axis", "x", "--value", "0.5"}, "position contradicts drive");
  expect_no_start_and_return({"limited_output", "--axis", "x"}, "output differs");
  ASSERT_EQ(stage.ctl({"go", "x", "12"}).status, 0);  // where 8 um more are within the limits of the position
  ASSERT_EQ(stage.ctl({"wait", "x", "--timeout", "5"}).status, 0);
  expect_fault_and_return({"sensor_offset", "--axis", "x", "--duration", "0.01"}, {"position jumped"});
}

TEST_F(TwinFaults, ThatAreShortOrSmallFaultNoAxis) {
  stage.start();
  inject({"wrong_crc", "--axis", "x", "--duration", "0.002"});
  inject({"load_step", "--axis", "x", "--value", "1", "--duration", "0.3"});
  inject({"duplicate", "--axis", "y", "--duration", "0.3"});
  std::this_thread::sleep_for(milliseconds(600));
  EXPECT_TRUE(twin_status().at("faults").empty());
  EXPECT_EQ(stage.axis_status(x).at("state"), "tracking");
  EXPECT_EQ(stage.axis_status(y).at("state"), "tracking");
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
