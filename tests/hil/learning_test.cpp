// Learning on real SocketCAN: as in virtual time.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/hil/live_bench.h"
#include "tests/support/shipped.h"

namespace hystcan::learning_test {
namespace {

using hil::json;
using hil::LiveBench;
using hil::Process;

/// Axis x of the shipped stage, which learns a triangle of 30 periods.
void make_learning(const support::ShippedCopy& stage) {
  stage.edit("piezo.toml", "cycles       = 10.0", "cycles       = 30.0");
  stage.edit("piezo.toml", "[axis.control.in_position]        # `hystcan ctl wait` needs it",
             "[axis.control.learning]\ncorrection_max_um = 1.0\n\n[axis.control.in_position]");
}

double triangle_percent(const json& axis) { return axis.at("segments")[0].at("rms_percent").get<double>(); }

// The noise of twin and bus differs; what is learnt does not.
TEST(Vcan, LearningTracksAsInVirtualTime) {
  const support::ShippedCopy stage;
  const std::string config = (stage / "piezo.toml").string();
  const auto rehearsed = [&] {
    Process demo(
        {HYSTCAN_PROGRAM, "demo", "--config", config, "--output", (stage / "demo").string(), "--json"});
    EXPECT_EQ(demo.wait(), 0) << demo.err();
    return triangle_percent(json::parse(demo.out()).at("columns").back());
  };
  const double without = rehearsed();
  make_learning(stage);
  const double expected = rehearsed();
  LiveBench bench({"vcan0", "vcan0"}, config);
  bench.start_controller({"--once", "--json"});
  ASSERT_EQ(bench.controller->wait(), 0) << bench.controller->err();
  const double found = triangle_percent(json::parse(bench.controller->out()).at("axes")[0]);
  std::printf("triangle, %% RMS: %.4f on vcan0, %.4f rehearsed, %.4f without learning\n", found, expected,
              without);
  EXPECT_LT(found, 0.5 * without);
  EXPECT_NEAR(found / expected, 1.0, 0.1);
}

}  // namespace
}  // namespace hystcan::learning_test
