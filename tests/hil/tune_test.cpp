// hystcan tune on real SocketCAN.
#include <gtest/gtest.h>

#include "tests/hil/live_bench.h"
#include "tests/support/shipped.h"

namespace hystcan::tune_test {
namespace {

using hil::LiveBench;
using hil::milliseconds;

TEST(Vcan, ControlCOnTuneRampsDownAndProposesNothing) {
  const support::ShippedCopy stage;
  const std::string output = (stage / "tuning.toml").string();
  LiveBench bench({"vcan0", "vcan0"});
  bench.start("tune", {"--output", output, "--cycles", "100"}, (stage / "piezo.toml").string());
  ASSERT_TRUE(bench.controller->says("x: tracking")) << bench.controller->err();
  std::this_thread::sleep_for(milliseconds(500));
  bench.controller->send(SIGINT);
  EXPECT_EQ(bench.controller->wait(), 1);
  EXPECT_NE(bench.controller->err().find("nothing is written"), std::string::npos) << bench.controller->err();
  EXPECT_FALSE(std::filesystem::exists(output));
  std::this_thread::sleep_for(milliseconds(100));
  hil::expect_stopped_by_a_ramp(bench.decoded());
}

}  // namespace
}  // namespace hystcan::tune_test
