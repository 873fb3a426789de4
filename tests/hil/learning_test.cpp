// Learning on real SocketCAN: as in virtual time.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/hil/live_bench.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shipped.h"

namespace hystcan::learning_test {
namespace {

using hil::json;
using hil::LiveBench;

/// Axis x of the shipped stage, which learns a triangle of 30 periods.
void make_learning(const support::ShippedCopy& stage) {
  stage.edit("piezo.toml", "cycles       = 10.0", "cycles       = 30.0");
  stage.edit("piezo.toml", "[axis.control.in_position]        # `hystcan ctl wait` needs it",
             "[axis.control.learning]\ncorrection_max_um = 1.0\n\n[axis.control.in_position]");
}

/// The beginning of a segment, which `controller` leaves out of its errors too.
constexpr double settle_s = 0.1;

/// RMS of the first segment, % of the stroke.
double first_percent(const json& axis) { return axis.at("segments")[0].at("rms_percent").get<double>(); }

double rehearsed_percent(const support::ShippedCopy& stage) {
  const config::Config config = config::load((stage / "piezo.toml").string());
  return support::triangle_percent(rehearsal::run_once(support::setup_of(config), settle_s, support::ignore));
}

double percent_on_vcan(const support::ShippedCopy& stage) {
  LiveBench bench({"vcan0", "vcan0"}, (stage / "piezo.toml").string());
  bench.start_controller({"--once", "--json"});
  EXPECT_EQ(bench.controller->wait(), 0) << bench.controller->err();
  return first_percent(json::parse(bench.controller->out()).at("axes")[0]);
}

// The noise of twin and bus differs; what is learnt does not.
TEST(Vcan, LearningTracksAsInVirtualTime) {
  const support::ShippedCopy stage;
  const double without = rehearsed_percent(stage);
  make_learning(stage);
  const double expected = rehearsed_percent(stage);
  const double found = percent_on_vcan(stage);
  std::printf("triangle, %% RMS: %.4f on vcan0, %.4f rehearsed, %.4f without learning\n", found, expected,
              without);
  EXPECT_LT(found, 0.5 * without);
  EXPECT_NEAR(found / expected, 1.0, 0.1);
}

}  // namespace
}  // namespace hystcan::learning_test
