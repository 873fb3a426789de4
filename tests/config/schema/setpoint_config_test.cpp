// The keys of the reference: every shape, limits, in_position, and the file of a "csv".
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <variant>

#include "config/files/csv.h"
#include "config/schema/config.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::setpoint_config_test {
namespace {

void write(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

/// Returns the message of load_setpoint's error without the folder.
std::string refusal(const std::string& text) {
  const support::ShippedCopy folder;
  write(folder / "r.csv", text);
  const std::string message = support::refusal_of([&] { load_setpoint(folder / "r.csv"); });
  return message.substr(message.find("r.csv"));
}

TEST(SetpointFile, StartsAtItsFirstTime) {
  const support::ShippedCopy folder;
  write(folder / "r.csv", "# a scan\nposition_um,time_s\n3.0,1.5\n7.0,2.0\n5.0,2.5\n");
  const controller::MonotoneCubic curve = load_setpoint(folder / "r.csv");
  EXPECT_EQ(curve.length(), 1.0);
  EXPECT_EQ(curve.at(0.0).value_um, 3.0);
  EXPECT_EQ(curve.at(0.5).value_um, 7.0);
  EXPECT_EQ(curve.at(9.0).value_um, 5.0);
}

TEST(SetpointFile, CountsALastRowWithoutItsLineEnd) {
  const support::ShippedCopy folder;
  write(folder / "r.csv", "time_s,position_um\n0,1\n1,2");
  EXPECT_EQ(load_setpoint(folder / "r.csv").at(9.0).value_um, 2.0);
}

TEST(SetpointFile, IsRefusedWithItsLine) {
  EXPECT_EQ(refusal("time_s,position_um\n0,1\n0.5,2\n0.5,3\n"),
            "r.csv:4:1: time_s is 0.5 after 0.5, expected an increasing time");
  EXPECT_EQ(refusal("time_s,position_um\n0,1\n"),
            "r.csv:2:1: the reference has 1 row, expected at least two");
  EXPECT_EQ(refusal("time_s,position_um\n0,1\n1,nan\n"),
            "r.csv:3:3: position_um is \"nan\", expected a finite number");
  EXPECT_EQ(refusal("time_s,position_um\n0,1\n1,2\n2"),
            "r.csv:4:1: the row has 1 field, expected 2 as in the header");
  EXPECT_EQ(refusal("time_s,x\n0,1\n"),
            "r.csv:1:1: no column position_um, expected a column with this name among time_s, x");
}

/// Returns the shipped piezo stage with these lines in place of x's triangle.
Config with_setpoint(const support::ShippedCopy& shipped, const std::string& lines) {
  shipped.edit("piezo.toml", "kind         = \"triangle\"",
               lines + "\n[[axis.control.setpoint]]\nkind = \"triangle\"");
  return load(shipped / "piezo.toml");
}

TEST(SetpointKeys, MakeEveryShape) {
  const support::ShippedCopy shipped;
  write(shipped / "scan.csv", "time_s,position_um\n0,1\n0.5,20\n");
  const std::string next = "\n[[axis.control.setpoint]]\n";
  const Config config = with_setpoint(
      shipped,
      "kind = \"step\"\nfrom_um = 10.0\nto_um = 11.0\ndwell_s = 0.5\nsteps = 3" + next +
          "kind = \"chirp\"\nlow_um = 10.0\nhigh_um = 12.0\nfrom_Hz = 1.0\nto_Hz = 50.0\nduration_s = 2.0\n"
          "fade_s = 0.2" +
          next +
          "kind = \"multi-sine\"\ncentre_um = 15.0\namplitudes_um = [1.0, 2.0]\nfrequencies_Hz = [5.0, 7.0]\n"
          "phases_deg = [0.0, 90.0]\nduration_s = 1.0" +
          next + "kind = \"csv\"\nfile = \"scan.csv\"");
  const auto& setpoint = config.axes[0].control.setpoint;
  const auto& step = std::get<controller::Step>(setpoint[0].shape);
  EXPECT_EQ(step.steps, 3u);
  EXPECT_EQ(step.dwell_s, 0.5);
  const auto& chirp = std::get<controller::Chirp>(setpoint[1].shape);
  EXPECT_EQ(chirp.to_Hz, 50.0);
  EXPECT_EQ(chirp.fade_s, 0.2);
  EXPECT_EQ(std::get<controller::MultiSine>(setpoint[2].shape).phases_deg, (std::vector{0.0, 90.0}));
  EXPECT_EQ(value_um(setpoint[3].shape, 9.0), 20.0);
  const std::string text = echo(shipped / "piezo.toml");
  for (const char* line : {"kind = \"csv\"\n", "file = \"scan.csv\"\n", "phases_deg = [0, 90]\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line;
}

TEST(SetpointKeys, LimitTheReferenceAndJudgeInPosition) {
  const support::ShippedCopy shipped;
  shipped.edit("piezo.toml", "tolerance_um = 0.05", "tolerance_um = 0.01");
  shipped.edit("piezo.toml", "repeat             = true",
               "reference_slew_um_per_s = 2000.0\nreference_acceleration_um_per_s2 = 2e5");
  const Config config = load(shipped / "piezo.toml");
  const controller::AxisConfig& x = config.axes[0].control;
  EXPECT_EQ(x.reference_limits.slew_um_per_s, 2000.0);
  EXPECT_EQ(x.reference_limits.acceleration_um_per_s2, 2e5);
  ASSERT_TRUE(x.in_position);
  EXPECT_EQ(x.in_position->tolerance_um, 0.01);
  EXPECT_EQ(x.in_position->window, std::chrono::milliseconds(20));
  EXPECT_EQ(x.in_position->timeout, std::chrono::milliseconds(1000));
  const controller::AxisConfig& y = config.axes[1].control;
  EXPECT_TRUE(std::isinf(y.reference_limits.slew_um_per_s));
  ASSERT_TRUE(y.in_position);
  EXPECT_EQ(y.in_position->tolerance_um, 0.05);
}

TEST(SetpointKeys, GiveATriangleTurnaroundsThatSpareTheMode) {
  const support::ShippedCopy shipped;
  shipped.edit("piezo.toml", "cycles       = 10.0", "cycles = 10.0\nturnaround_percent = 4.0");
  const Config config = load(shipped / "piezo.toml");
  const auto& triangle = std::get<controller::Triangle>(config.axes[0].control.setpoint[0].shape);
  EXPECT_EQ(triangle.turnaround_percent, 4.0);
  EXPECT_EQ(triangle.mode_period_s, 1.0 / 500.0);
}

TEST(SetpointKeys, MakeARaster) {
  const support::ShippedCopy shipped;
  shipped.edit(
      "raster.toml", "turnaround_percent = 10.0 ",
      "both_directions = false\nflyback_percent = 25.0\nframes = 3\nslow = \"ramp\"\nturnaround_percent = "
      "8.0");
  shipped.edit("raster.toml", "turnaround_percent = 10.0 ",
               "both_directions = false\nflyback_percent = 25.0\nframes = 3\nturnaround_percent = 8.0");
  const Config config = load(shipped / "raster.toml");
  const auto& fast = std::get<controller::Raster>(config.axes[0].control.setpoint[0].shape);
  EXPECT_EQ(fast.role, controller::ScanRole::fast);
  EXPECT_EQ(fast.lines, 32U);
  EXPECT_EQ(fast.return_lines, 2U);
  EXPECT_EQ(fast.frames, 3U);
  EXPECT_EQ(fast.pixels, 32U);
  EXPECT_FALSE(fast.both_directions);
  EXPECT_EQ(fast.flyback_percent, 25.0);
  EXPECT_EQ(fast.slow, controller::SlowMotion::ramp);
  EXPECT_EQ(std::get<controller::Raster>(config.axes[1].control.setpoint[0].shape).role,
            controller::ScanRole::slow);
}

/// Returns the refusal of the shipped scan with this edit.
std::string refusal_of_scan(const std::string& what, const std::string& with) {
  const support::ShippedCopy shipped;
  shipped.edit("raster.toml", what, with);
  const std::string message = support::refusal_of([&] { load(shipped / "raster.toml"); });
  return message.substr(message.find(": ") + 2);
}

TEST(Scan, IsRefusedIfItsAxesHaveDifferentLines) {
  EXPECT_EQ(refusal_of_scan("lines              = 32", "lines = 64"),
            "lines is 32, expected 64 as on axis x of the same scan");
  EXPECT_EQ(refusal_of_scan("line_rate_Hz       = 20.0", "line_rate_Hz = 10.0"),
            "line_rate_Hz is 20, expected 10 as on axis x of the same scan");
  EXPECT_EQ(refusal_of_scan("turnaround_percent = 10.0", "turnaround_percent = 20.0"),
            "turnaround_percent is 10, expected 20 as on axis x of the same scan");
}

TEST(Scan, IsRefusedIfItsAxesBeginAtDifferentTimes) {
  EXPECT_EQ(refusal_of_scan("transition_s       = 0.2", "transition_s = 0.3"),
            "the time in s from the start to the scan is 0.2, expected 0.3 as on axis x of the same scan");
  EXPECT_EQ(refusal_of_scan("repeat             = true", "repeat = false"),
            "the reference repeats, expected the same as on axis x of the same scan");
}

// 25 um, from the far end, along the smooth step at 380 um/s last 0.123 s.
TEST(Scan, IsRefusedIfItsTransitionIsTooShort) {
  const std::string file = HYSTCAN_SOURCE_DIR "/config/raster.toml";
  std::vector<Setting> settings{{"axis[1].control.reference_slew_um_per_s", "380"},
                                {"axis[0].control.setpoint[0].transition_s", "0.13"},
                                {"axis[1].control.setpoint[0].transition_s", "0.13"}};
  EXPECT_NO_THROW(load(file, settings));
  settings[1].value = settings[2].value = "0.1";
  const std::string error = support::refusal_of([&] { load(file, settings); });
  EXPECT_NE(error.find("transition_s is 0.1, expected at least 0.12"), std::string::npos) << error;
}

TEST(Scan, NeedsAMessageForItsMarkers) {
  const support::ShippedCopy shipped;
  shipped.edit("hystcan.dbc", "BO_ 897 XScanMarker", "BO_ 897 XScanMark");
  const std::string error = support::refusal_of([&] { load(shipped / "raster.toml"); });
  EXPECT_NE(error.find("no message XScanMarker in hystcan.dbc, expected this message for scan_marker = true"),
            std::string::npos)
      << error;
}

TEST(Scan, IsRefusedIfItsNumbersAreInconsistent) {
  EXPECT_NE(refusal_of_scan("return_lines       = 2", "return_lines = 1").find("expected an even number"),
            std::string::npos);
}

controller::AxisConfig x_of(const Config& config) { return config.axes[0].control; }

TEST(ReferenceLimits, AreDerivedFromDriveAndModeForTransitions) {
  const Config config = load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  const controller::AxisConfig x = x_of(config);
  const controller::ReferenceLimits expected =
      controller::default_transition_limits(x.gate, x.law.model, x.delays);
  EXPECT_EQ(x.transition_limits.slew_um_per_s, expected.slew_um_per_s);
  EXPECT_EQ(x.transition_limits.acceleration_um_per_s2, expected.acceleration_um_per_s2);
  EXPECT_TRUE(std::isinf(x.reference_limits.slew_um_per_s)) << "shapes are what was asked for";
  const std::string text = echo(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  for (const char* line :
       {"# reference_slew_um_per_s = 2850  # default, applies only to transitions\n",
        "# reference_acceleration_um_per_s2 = 281284  # default, applies only to transitions\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
}

TEST(ReferenceLimits, AreOnlyTheGivenOnesIfConfigured) {
  const std::string file = HYSTCAN_SOURCE_DIR "/config/piezo.toml";
  const std::string control = "axis[0].control.";
  for (const char* given : {"4000.0", "inf"}) {
    const std::vector<Setting> slew{{control + "reference_slew_um_per_s", given}};
    const controller::AxisConfig x = x_of(load(file, slew));
    EXPECT_EQ(x.reference_limits.slew_um_per_s, std::stod(given));
    EXPECT_TRUE(std::isinf(x.transition_limits.slew_um_per_s));
    EXPECT_TRUE(std::isfinite(x.transition_limits.acceleration_um_per_s2)) << "each for itself";
    const std::string line =
        std::string("\nreference_slew_um_per_s = ") + (*given == 'i' ? "inf\n" : "4000\n");
    EXPECT_NE(echo(file, slew).find(line), std::string::npos) << echo(file, slew);
  }
  for (const char* wrong : {"-inf", "nan", "0.0", "-5.0"})
    EXPECT_THROW(load(file, {{control + "reference_acceleration_um_per_s2", wrong}}), Error) << wrong;
}

}  // namespace
}  // namespace hystcan::config::setpoint_config_test
