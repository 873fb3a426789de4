// The state file: what an axis remembers, over a clean stop and a new start.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/hil/stage.h"

namespace hystcan {
namespace {

using hil::between;
using hil::json;
using hil::milliseconds;
using hil::now_s;
using hil::OnWire;
using hil::series;
using hil::Stage;

struct Restore : testing::Test {
  Stage stage;
  std::filesystem::path state = stage.files / "x.state.toml";

  void SetUp() override { stage.set("controller", "state_dir = \"" + stage.folder() + "\""); }
  /// A run of some passes that ends in order, by another exit status where not.
  void run_and_stop() {
    stage.start();
    EXPECT_FALSE(std::filesystem::exists(state)) << "it tells the truth only until the actuator is driven";
    std::this_thread::sleep_for(milliseconds(500));
    stage.bench.controller->send(SIGTERM);
    ASSERT_EQ(stage.bench.controller->wait(), 0) << stage.bench.controller->err();
  }
  void from_now_on_restore_x() const {
    stage.files.edit("piezo.toml", "wipe_slew_V_per_s",
                     "start_up           = \"restore\"\nwipe_slew_V_per_s");
  }
  void expect_refused(const std::string& why) {
    stage.bench.start_controller();
    EXPECT_EQ(stage.bench.controller->wait(), 2) << stage.bench.controller->err();
    EXPECT_NE(stage.bench.controller->err().find(why), std::string::npos) << stage.bench.controller->err();
  }
};

double highest(const std::vector<OnWire>& values) {
  EXPECT_FALSE(values.empty());
  return values.empty() ? NAN : std::ranges::max(values, {}, &OnWire::value).value;
}

/// By the controller's own word on the wire, which comes at the change.
double begins_to_track_s(const std::vector<OnWire>& statuses) {
  constexpr int tracking = 4;
  const auto first = std::ranges::find(statuses, tracking, &OnWire::byte4);
  EXPECT_TRUE(first != statuses.end()) << "it never says so";
  return first == statuses.end() ? NAN : first->time_s;
}

TEST_F(Restore, ACleanStopIsTakenUpByTheNextStartWithoutAWayToTheThresholds) {
  run_and_stop();
  ASSERT_TRUE(std::filesystem::exists(state)) << stage.bench.controller->err();
  const double between_s = now_s();
  from_now_on_restore_x();
  stage.bench.start_controller({"--json"});
  ASSERT_TRUE(stage.bench.controller->says("x: tracking")) << stage.bench.controller->err();
  EXPECT_FALSE(std::filesystem::exists(state));
  ASSERT_TRUE(stage.bench.controller->says("y: tracking")) << stage.bench.controller->err();
  std::this_thread::sleep_for(milliseconds(1500));
  const json result = stage.bench.ended(0);
  EXPECT_LT(result.at("axes").at(0).at("rms_percent"), 1.0) << "the memory is the actuator's";
  EXPECT_TRUE(std::filesystem::exists(state)) << "and saved again";
  const json log = stage.bench.decoded("--series");
  const std::vector<OnWire> x = series(log, "X", "AmpCommand");
  const std::vector<OnWire> y = series(log, "Y", "AmpCommand");
  EXPECT_GT(highest(between(x, 0.0, between_s)), 99.9) << "the first start wiped up to drive_max";
  EXPECT_GT(highest(between(y, between_s, now_s())), 99.9) << "y wipes again";
  // The way to the first setpoint, 3 um, takes 0.2 s; 3 um are 10 V at most, with the loop's width.
  const double tracking_s =
      begins_to_track_s(between(series(log, "X", "ControllerStatus"), between_s, now_s()));
  EXPECT_LT(highest(between(x, between_s, tracking_s + 0.15)), 10.0);
  EXPECT_LT(highest(between(x, between_s, now_s())), 99.0) << "27 um are the highest that it is to reach";
}

TEST_F(Restore, AfterAKillThereIsNothingToTakeUpAndTheStartIsRefused) {
  run_and_stop();
  ASSERT_TRUE(std::filesystem::exists(state));
  stage.start();
  stage.bench.controller->send(SIGKILL);
  EXPECT_EQ(stage.bench.controller->wait(), 128 + SIGKILL);
  EXPECT_FALSE(std::filesystem::exists(state));
  from_now_on_restore_x();
  expect_refused("the last stop was not a clean one");
}

TEST_F(Restore, TheMemoryOfAnotherModelIsRefused) {
  run_and_stop();
  ASSERT_TRUE(std::filesystem::exists(state));
  from_now_on_restore_x();
  stage.files.edit("piezo.model.toml", "k_ascending  = 0.035", "k_ascending  = 0.034");
  expect_refused("the memory of another model");
  EXPECT_TRUE(std::filesystem::exists(state)) << "its model may come back";
}

TEST_F(Restore, ADamagedFileIsRefusedWithItsPlace) {
  run_and_stop();
  from_now_on_restore_x();
  stage.files.edit("x.state.toml", "[memory]", "[memory");
  expect_refused("x.state.toml:");
}

}  // namespace
}  // namespace hystcan
