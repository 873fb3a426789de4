// The twin's faults between two processes on vcan: a test injects them by the twin's own socket, and the
// controller reports the same causes as on the simulated bus (tests/safety/twin_fault_test.cpp).
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/hil/live_stage.h"

namespace hystcan::twin_faults_test {
namespace {

using hil::json;
using hil::QuickStage;

constexpr std::size_t x = 0;
constexpr std::size_t y = 1;

TEST(TwinFaults, FaultTheAxisUntilTheyAreRemovedAndItIsCleared) {
  QuickStage stage;
  stage.start();
  for (const auto& [fault, cause] :
       {std::pair{"wrong_crc", "sample missing"}, std::pair{"amplifier_trip", "amplifier fault"}}) {
    ASSERT_EQ(stage.ctl_twin({"inject", fault, "--axis", "x"}).status, 0) << fault;
    ASSERT_TRUE(stage.reaches(x, "faulted")) << fault;
    EXPECT_EQ(stage.axis_status(x).at("fault"), cause);
    EXPECT_EQ(stage.axis_status(y).at("state"), "tracking") << fault;
    EXPECT_TRUE(stage.bench.twin->says(std::string(fault) + " begins")) << stage.bench.twin->err();
    EXPECT_EQ(stage.ctl_twin({"remove"}).status, 0);
    EXPECT_TRUE(json::parse(stage.ctl_twin({"--json", "status"}).out).at("faults").empty());
    ASSERT_EQ(stage.ctl({"clear", "x"}).status, 0);
    ASSERT_TRUE(stage.reaches(x, "offline"));
    ASSERT_EQ(stage.ctl({"enable", "x"}).status, 0);
    ASSERT_TRUE(stage.reaches(x, "tracking")) << fault;
  }
}

}  // namespace
}  // namespace hystcan::twin_faults_test
