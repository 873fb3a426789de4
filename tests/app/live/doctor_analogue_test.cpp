// The findings of `hystcan doctor` about the cards of analogue axes.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "app/live/doctor.h"
#include "tests/support/scratch.h"

namespace hystcan::doctor_analogue_test {
namespace {

using app::Finding;
using app::Verdict;

/// Axis x of the shipped stage on the simulated card; the root contains no processes.
class AnalogueAxis : public testing::Test {
 protected:
  AnalogueAxis() {
    settings = {{"axis[0].analogue.device", "\"simulated:12\""},
                {"axis[0].analogue.volts_per_drive", "0.1"},
                {"axis[0].analogue.position_um_per_V", "5.0"},
                {"axis[0].analogue.drive_output.channel", "0"},
                {"axis[0].analogue.drive_output.range", "\"-10..10 V\""},
                {"axis[0].analogue.position_input.channel", "0"},
                {"axis[0].analogue.position_input.average", "4"}};
  }
  std::vector<Finding> examine() const {
    return app::examine_analogue(config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml", settings), root);
  }
  Finding of(const std::string& check) const {
    const auto findings = examine();
    const auto found = std::ranges::find(findings, check, &Finding::check);
    if (found != findings.end()) return *found;
    ADD_FAILURE() << "no check " << check;
    return {};
  }
  void put(const std::filesystem::path& file, const std::string& text) const {
    std::filesystem::create_directories((root / file).parent_path());
    std::ofstream(root / file) << text << '\n';
  }
  /// A process `hystcan node`.
  void run_node(const std::string& policy, const std::string& locked) const {
    put("proc/17/comm", "hystcan");
    put("proc/17/cmdline", std::string("/usr/bin/hystcan\0node\0stage.toml\0", 33));
    std::string stat = "17 (hystcan)";
    for (int field = 3; field < 40; ++field) stat += " 0";
    put("proc/17/stat", stat + " 45 " + policy);
    put("proc/17/status", "VmLck:\t    " + locked + " kB");
  }

  std::vector<config::Setting> settings;
  const support::ScratchFolder scratch;
  const std::filesystem::path& root = scratch.path();
};

TEST_F(AnalogueAxis, HasTheRangesAndResolutionsOfItsCard) {
  EXPECT_EQ(of("x device").figure, "simulated:12");
  EXPECT_EQ(of("x output").figure,
            "range -10 to 10 V, of which the drives use 0 to 10 V; resolution 0.0488 V");
  EXPECT_EQ(of("x input").figure, "range -10 to 10 V measures -50 to 50 um; resolution 24.4 nm");
}

TEST_F(AnalogueAxis, HasTheNoiseAndTheTimeOfASample) {
  EXPECT_NE(of("x noise").figure.find("nm RMS in "), std::string::npos) << of("x noise").figure;
  EXPECT_NE(of("x sample").figure.find("us for 4 conversions"), std::string::npos) << of("x sample").figure;
}

TEST_F(AnalogueAxis, IsBadIfTheCardIsMissing) {
  settings[0].value = "\"comedi:/dev/null/card\"";
  EXPECT_EQ(of("x device").verdict, Verdict::bad);
  EXPECT_FALSE(of("x device").cure.empty());
}

TEST_F(AnalogueAxis, IsBadIfTheCardHasNoSuchLine) {
  settings.push_back({"axis[0].analogue.charge_pump_line.device", "\"comedi:/dev/null\""});
  settings.push_back({"axis[0].analogue.charge_pump_line.line", "0"});
  EXPECT_EQ(of("x charge_pump_line.device").verdict, Verdict::bad);
}

TEST_F(AnalogueAxis, IsBadWithoutAPosition) {
  settings.push_back({"axis[0].twin.sensor.offset_um", "1000.0"});  // 200 V
  EXPECT_EQ(of("x noise").verdict, Verdict::bad);
}

TEST_F(AnalogueAxis, IsDoubtfulWithoutItsWholeStroke) {
  settings.push_back({"axis[0].analogue.position_zero_um", "-22.0"});  // the setpoint reaches 27 um
  EXPECT_EQ(of("x input").verdict, Verdict::doubtful);
  EXPECT_NE(of("x input").figure.find("measures -71.98 to 27.98 um, but the stroke is"), std::string::npos)
      << of("x input").figure;
}

TEST_F(AnalogueAxis, PrintsNoNegativeZero) {
  settings.push_back({"axis[0].analogue.volts_per_drive", "-0.1"});
  EXPECT_EQ(of("x output").figure,
            "range -10 to 10 V, of which the drives use 0 to -10 V; resolution 0.0488 V");
}

TEST(ARefusal, ShowsItsRemedyAsCure) {
  const Finding finding = app::refused(
      "card", Verdict::bad, Error("card0", "a; b", {.expected = "c; d", .remedy = "name another; or none"}));
  EXPECT_EQ(finding.figure, "card0: a; b, expected c; d");
  EXPECT_EQ(finding.cure, "name another; or none");
}

TEST_F(AnalogueAxis, HasAFutureNodeOfTheConfiguredClass) {
  EXPECT_EQ(of("node").verdict, Verdict::doubtful);
  settings.push_back({"controller.realtime.priority", "45"});
  settings.push_back({"controller.realtime.lock_memory", "true"});
  EXPECT_EQ(of("node").figure, "not running; will run with FIFO 46, memory locked");
}

TEST_F(AnalogueAxis, IsNotOpenedWhileANodeRuns) {
  run_node("1", "51200");
  EXPECT_EQ(of("node").figure, "process 17: FIFO 45, 51200 kB locked");
  EXPECT_EQ(of("node").verdict, Verdict::good);
  EXPECT_EQ(examine().size(), 2u);
}

TEST_F(AnalogueAxis, HasADoubtfulNodeWithoutPriorityOrLockedMemory) {
  run_node("0", "51200");
  EXPECT_EQ(of("node").verdict, Verdict::doubtful);
  run_node("1", "0");
  EXPECT_EQ(of("node").verdict, Verdict::doubtful);
}

TEST(OtherAxes, HaveNoFindingsOfCards) {
  EXPECT_TRUE(app::examine_analogue(config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml")).empty());
}

}  // namespace
}  // namespace hystcan::doctor_analogue_test
