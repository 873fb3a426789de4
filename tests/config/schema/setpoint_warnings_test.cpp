#include "config/schema/check.h"

#include <gtest/gtest.h>

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

TEST(SetpointWarnings, AreNotMadeForShippedConfigurations) {
  for (const char* file : {"piezo.toml", "galfenol.toml", "lab_amplifier.toml", "p733.toml",
                           "galfenol_unimorph.toml", "soft_stage.toml", "fd_stage.toml", "fd_eight.toml"}) {
    const auto found = warnings(file);
    EXPECT_TRUE(found.empty()) << file << ": " << found.front();
  }
}

TEST(SetpointWarnings, NameADriveThatMayGoFarBeyondModelAndTwin) {
  const auto found = warnings("piezo.toml", {{"axis[0].control.drive_max_V", "1000.0"}});
  ASSERT_GE(found.size(), 2u);
  EXPECT_EQ(found[0], "axis x: the drive may go from 0 to 1000 V, the model's range is 0 to 100 V");
  EXPECT_EQ(found[1], "axis x: the drive may go from 0 to 1000 V, the twin's range is -20 to 120 V");
}

TEST(SetpointWarnings, NameAReferenceBeyondTheReachOfTheModel) {
  EXPECT_TRUE(warns({{"axis[0].control.setpoint[0].high_um", "33.0"}}, "to 33 um, but the model reaches"));
}

// 24 um at 20 Hz are 960 um/s; the flattest branch needs 1 V for each 0.22 um.
TEST(SetpointWarnings, NameADriveThatMustChangeFasterThanItsSlew) {
  const std::vector<Setting> fast{{"axis[0].control.setpoint[0].frequency_Hz", "20.0"},
                                  {"axis[0].control.slew_V_per_s", "3000.0"}};
  EXPECT_TRUE(warns(fast, "slew_V_per_s is 3000"));
  EXPECT_FALSE(warns({fast[0]}, "slew_V_per_s"));
}

// Compensating the mode, a corner takes a pulse that the speed of the triangle alone does not show.
TEST(SetpointWarnings, NameACornerWhosePulseIsFasterThanTheSlewWherePlantInverseMakesIt) {
  const auto of_sharp_corners = [](const char* plant_inverse) {
    return warnings("fd_stage.toml", {{"axis[0].control.setpoint[0].turnaround_percent", "0.0"},
                                      {"axis[0].control.slew_V_per_s", "20000.0"},
                                      {"axis[0].control.delays.plant_inverse", plant_inverse}});
  };
  const auto found = of_sharp_corners("true");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].starts_with("axis x, setpoint[0]: the drive must change by up to ")) << found[0];
  EXPECT_TRUE(found[0].ends_with(" times as slow would do, or smoother corners (turnaround_percent)"));
  EXPECT_TRUE(of_sharp_corners("false").empty());
}

TEST(SetpointWarnings, NameAFrequencyThatTheCyclesCannotShow) {
  EXPECT_TRUE(warns({{"axis[0].control.setpoint[0].frequency_Hz", "600.0"}}, "a period has 1.67 cycles"));
  EXPECT_FALSE(warns({{"axis[0].control.setpoint[0].frequency_Hz", "40.0"}}, "a period has"));
}

TEST(SetpointWarnings, NameAStepThatIsLargerThanTheFollowingErrorAndTheJump) {
  const std::vector<Setting> step{{"axis[0].control.setpoint[1].rise_s", "0.0"}};
  EXPECT_TRUE(warns(step, "a step of 22 um, but following_error_um is 4"));
  EXPECT_TRUE(warns(step, "up to 22 um in a cycle, but position_jump_um is 5"));
}

TEST(SetpointWarnings, LeaveOutAJumpThatIsNotJudged) {
  EXPECT_FALSE(
      warns({{"axis[0].control.setpoint[1].rise_s", "0.0"}, {"axis[0].control.position_jump_um", "0.0"}},
            "position_jump_um"));
}

}  // namespace
}  // namespace hystcan::config::setpoint_warnings_test
