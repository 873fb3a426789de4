#include "config/schema/setpoint_warnings.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "config/schema/check.h"
#include "config/schema/config.h"

namespace hystcan::config::setpoint_warnings_test {
namespace {

std::vector<std::string> warnings(const std::string& file, const std::vector<Setting>& settings = {}) {
  return setpoint_warnings(load(HYSTCAN_SOURCE_DIR "/config/" + file, settings));
}

bool warns(const std::vector<Setting>& settings, const std::string& of) {
  for (const std::string& warning : warnings("piezo.toml", settings))
    if (warning.starts_with("axis x, setpoint[") && warning.find(of) != std::string::npos) return true;
  return false;
}

TEST(SetpointWarnings, AreAbsentForShippedConfigurations) {
  for (const char* file :
       {"piezo.toml", "galfenol.toml", "lab_amplifier.toml", "p733.toml", "galfenol_unimorph.toml",
        "soft_stage.toml", "fd_stage.toml", "fd_stage_learning.toml", "fd_eight.toml"}) {
    const auto found = warnings(file);
    EXPECT_TRUE(found.empty()) << file << ": " << found.front();
  }
}

TEST(SupervisionWarnings, AreAbsentForShippedConfigurations) {
  std::size_t configurations = 0;
  for (const auto& entry : std::filesystem::directory_iterator(HYSTCAN_SOURCE_DIR "/config")) {
    const std::filesystem::path& file = entry.path();
    if (file.extension() != ".toml" || file.stem().has_extension()) continue;  // x.model.toml
    ++configurations;
    for (const std::string& warning : supervision_warnings(load(file)))
      ADD_FAILURE() << file << ": " << warning;
  }
  EXPECT_GE(configurations, 9U);
}

TEST(SupervisionWarnings, NameEveryDisabledCheckOfAnAxisWithFeedback) {
  const auto found = [](const char* structure) {
    return supervision_warnings(
        load(HYSTCAN_SOURCE_DIR "/config/piezo.toml", {{"axis[0].control.structure", structure},
                                                       {"axis[0].control.position_jump_um", "0.0"},
                                                       {"axis[0].control.following_error_um", "37.0"},
                                                       {"axis[0].control.frozen_cycles", "0"},
                                                       {"axis[0].control.saturated_s", "0.0"},
                                                       {"axis[0].control.bus_passive_s", "0.0"},
                                                       {"axis[0].control.status_timeout_ms", "0.0"}}));
  };
  const std::vector<std::string> expected{
      "axis x: position_jump_um is 0, so that `position jumped` is never detected",
      "axis x: following_error_um is 37, so that `following error` is never detected",
      "axis x: frozen_cycles is 0, so that `position frozen` is never detected",
      "axis x: saturated_s is 0, so that `saturated` is never detected",
      "axis x: bus_passive_s is 0, so that `bus passive` is never detected",
      "axis x: status_timeout_ms is 0, so that `status missing` is never detected"};
  EXPECT_EQ(found("\"inverse+pi\""), expected);
  EXPECT_TRUE(found("\"inverse\"").empty());
}

TEST(SetpointWarnings, NameADriveRangeFarBeyondModelAndTwin) {
  const auto found = warnings("piezo.toml", {{"axis[0].control.drive_max_V", "1000.0"}});
  ASSERT_GE(found.size(), 2u);
  EXPECT_EQ(found[0],
            "axis x: the drive range, 0 to 1000 V, extends far beyond the model's range, 0 to 100 V: check "
            "drive_min and drive_max");
  EXPECT_EQ(found[1],
            "axis x: the drive range, 0 to 1000 V, extends far beyond the twin's range, -20 to 120 V: check "
            "drive_min and drive_max");
}

TEST(SetpointWarnings, NameAReferenceBeyondTheReachOfTheModel) {
  EXPECT_TRUE(warns({{"axis[0].control.setpoint[0].high_um", "33.0"}}, "to 33 um, but the model reaches"));
}

// 24 um at 20 Hz are 960 um/s; the flattest branch needs 1 V for every 0.22 um.
TEST(SetpointWarnings, NameADriveThatMustChangeFasterThanItsSlew) {
  const std::vector<Setting> fast{{"axis[0].control.setpoint[0].frequency_Hz", "20.0"},
                                  {"axis[0].control.slew_V_per_s", "3000.0"}};
  EXPECT_TRUE(warns(fast, "slew_V_per_s is 3000"));
  EXPECT_FALSE(warns({fast[0]}, "slew_V_per_s"));
}

// To compensate the mode, a corner needs a pulse that is not visible from the speed of the triangle alone.
TEST(SetpointWarnings, NameACornerTooSharpForThePlantInverse) {
  const auto of_sharp_corners = [](const char* plant_inverse) {
    return warnings("fd_stage.toml", {{"axis[0].control.setpoint[0].turnaround_percent", "0.0"},
                                      {"axis[0].control.slew_V_per_s", "20000.0"},
                                      {"axis[0].control.delays.plant_inverse", plant_inverse}});
  };
  const auto found = of_sharp_corners("true");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].starts_with("axis x, setpoint[0]: the drive must change by up to ")) << found[0];
  EXPECT_TRUE(found[0].ends_with(" times as slow, or its corners smoother (turnaround_percent)"));
  EXPECT_TRUE(of_sharp_corners("false").empty());
}

TEST(SetpointWarnings, NameAFrequencyTooHighForTheCycleRate) {
  EXPECT_TRUE(warns({{"axis[0].control.setpoint[0].frequency_Hz", "600.0"}}, "a period has 1.67 cycles"));
  EXPECT_FALSE(warns({{"axis[0].control.setpoint[0].frequency_Hz", "40.0"}}, "a period has"));
}

TEST(SetpointWarnings, NameAStepAboveTheFollowingErrorAndJumpLimits) {
  const std::vector<Setting> step{{"axis[0].control.setpoint[1].rise_s", "0.0"}};
  EXPECT_TRUE(warns(step, "a step of 22 um, but following_error_um is 4"));
  EXPECT_TRUE(warns(step, "up to 22 um in a cycle, but position_jump_um is 5"));
}

TEST(SetpointWarnings, OmitAJumpWithoutALimit) {
  EXPECT_FALSE(
      warns({{"axis[0].control.setpoint[1].rise_s", "0.0"}, {"axis[0].control.position_jump_um", "0.0"}},
            "position_jump_um"));
}

}  // namespace
}  // namespace hystcan::config::setpoint_warnings_test
