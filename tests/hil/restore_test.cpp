// The state file: stores the memory of an axis from a clean stop to the next start.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/hil/live_stage.h"

namespace hystcan::restore_test {
namespace {

using hil::between;
using hil::json;
using hil::LiveStage;
using hil::milliseconds;
using hil::now_s;
using hil::OnWire;
using hil::series;

double highest(const std::vector<OnWire>& values) {
  EXPECT_FALSE(values.empty());
  return values.empty() ? NAN : std::ranges::max(values, {}, &OnWire::value).value;
}

/// Returns the time of the status that the controller sends when its state becomes tracking.
double begins_to_track_s(const std::vector<OnWire>& statuses) {
  constexpr int tracking = 4;
  const auto first = std::ranges::find(statuses, tracking, &OnWire::byte4);
  EXPECT_TRUE(first != statuses.end()) << "no status says tracking";
  return first == statuses.end() ? NAN : first->time_s;
}

TEST(Restore, TheMemoryOfACleanStopIsUsedByTheNextStartWithoutWiping) {
  LiveStage stage;
  const std::filesystem::path state = stage.files / "x.state.toml";
  stage.set("controller", "state_dir = \"" + stage.folder() + "\"");
  stage.start();
  EXPECT_FALSE(std::filesystem::exists(state)) << "the file is true only until the actuator is driven";
  std::this_thread::sleep_for(milliseconds(500));
  stage.bench.controller->send(SIGTERM);
  ASSERT_EQ(stage.bench.controller->wait(), 0) << stage.bench.controller->err();
  ASSERT_TRUE(std::filesystem::exists(state)) << stage.bench.controller->err();
  const double between_s = now_s();
  stage.files.edit("piezo.toml", "wipe_slew_V_per_s", "start_up           = \"restore\"\nwipe_slew_V_per_s");
  stage.bench.start_controller({"--json"});
  ASSERT_TRUE(stage.bench.controller->says("x: tracking")) << stage.bench.controller->err();
  EXPECT_FALSE(std::filesystem::exists(state));
  ASSERT_TRUE(stage.bench.controller->says("y: tracking")) << stage.bench.controller->err();
  std::this_thread::sleep_for(milliseconds(1500));
  const json result = stage.bench.stop_and_report(0);
  EXPECT_LT(result.at("axes").at(0).at("rms_percent"), 1.0) << "the memory is that of the actuator";
  EXPECT_TRUE(std::filesystem::exists(state)) << "the file is saved again";
  const json log = stage.bench.decoded_with_series();
  const std::vector<OnWire> x = series(log, "X", "AmpCommand");
  const std::vector<OnWire> y = series(log, "Y", "AmpCommand");
  EXPECT_GT(highest(between(x, 0.0, between_s)), 99.9) << "the first start wiped up to drive_max";
  EXPECT_GT(highest(between(y, between_s, now_s())), 99.9) << "y wipes again";
  // The motion to the first setpoint, 3 um, takes 0.2 s; 3 um correspond to at most 10 V, including the
  // loop's width.
  const double tracking_s =
      begins_to_track_s(between(series(log, "X", "ControllerStatus"), between_s, now_s()));
  EXPECT_LT(highest(between(x, between_s, tracking_s + 0.15)), 10.0);
  EXPECT_LT(highest(between(x, between_s, now_s())), 99.0)
      << "27 um is the highest position of the reference";
}

}  // namespace
}  // namespace hystcan::restore_test
