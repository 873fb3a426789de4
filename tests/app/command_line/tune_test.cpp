// `hystcan tune`, rehearsed: its estimates, proposals, predictions and errors.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "tests/app/command_line/cli.h"

namespace hystcan::tune_test {
namespace {

using nlohmann::json;

/// Present gains that are slower than the gains of tune.
class Tune : public Cli {
 protected:
  void SetUp() override {
    std::string text = read("piezo.toml");
    text = std::regex_replace(text, std::regex("(\nkp +)= [0-9.]+"), "$1= 0.05");
    write("piezo.toml", std::regex_replace(text, std::regex("(\nki_per_s +)= [0-9.]+"), "$1= 120.0"));
  }
  Process tune(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{HYSTCAN_PROGRAM, "tune",     path("piezo.toml"),
                                   "--rehearse",    "--output", path("tuning.toml")};
    words.insert(words.end(), more.begin(), more.end());
    return Process(words);
  }
  json tuned(std::vector<std::string> more = {}) const {
    more.emplace_back("--json");
    Process program = tune(more);
    EXPECT_EQ(program.wait(), done) << program.err();
    return json::parse(program.out());
  }
  /// The answer for the stage of SetUp(), computed once for all tests.
  const json& tuned_once() const {
    static const json found = tuned();
    return found;
  }
  static json named(const json& found, const std::string& name) {
    for (const json& candidate : found["candidates"])
      if (candidate["name"] == name) return candidate;
    ADD_FAILURE() << "no candidate " << name;
    return nullptr;
  }
  bool written() const { return std::filesystem::exists(shipped / "tuning.toml"); }

  /// RMS error of axis x with inverse+pi in the demo, % of stroke.
  double demonstrated(const char* config) const {
    Process demo({HYSTCAN_PROGRAM, "demo", "--config", path(config), "--output", path("demo"), "--json"});
    EXPECT_EQ(demo.wait(), done) << demo.err();
    const json table = json::parse(demo.out());
    return table["columns"].back()["rms_percent"].get<double>();
  }
};

// The twin has 500 Hz and 0.05. Its amplifier has a lag of 0.106 ms, not a delay; near half the cycle rate
// the two differ by some hundredths of a millisecond.
TEST_F(Tune, FindsTheTwinsModeFromAFewSmallSteps) {
  const json& found = tuned_once();
  EXPECT_NEAR(found["natural_frequency_Hz"]["value"], 500.0, 5.0);
  EXPECT_NEAR(found["damping_ratio"]["value"], 0.05, 0.005);
  EXPECT_NEAR(found["delay_s"]["value"], 0.106e-3, 0.06e-3);
  EXPECT_EQ(found["steps"]["amplitude"], 1.0) << "1 % of 100 V";
  EXPECT_EQ(found["steps"]["centre"], 50.0);
  EXPECT_EQ(found["rows"], 2400) << "five steps up and down and half a one before and after, 0.4 s each";
}

// Each rule holds, and the limiting rule holds with equality.
TEST_F(Tune, ProposesCautiousGainsThatKeepTheRequestedMargins) {
  double ki_before = 1e9;
  for (const auto& [phase_deg, gain_dB] :
       {std::pair(45.0, 3.0), std::pair(60.0, 6.0), std::pair(75.0, 12.0)}) {
    const json cautious = named(tuned({"--cautious", "--phase-margin", std::to_string(phase_deg),
                                       "--gain-margin", std::to_string(gain_dB)}),
                                "cautious");
    EXPECT_TRUE(cautious["margins"]["stable"]);
    // Tolerance: the frequency grid, and the three digits of the gains.
    EXPECT_GE(cautious["margins"]["phase_margin_deg"], phase_deg - 0.5);
    EXPECT_GE(cautious["margins"]["gain_margin_dB"], gain_dB - 0.1);
    EXPECT_NEAR(20.0 * std::log10(cautious["worst_margins"]["peak_beyond_180"].get<double>()), -gain_dB, 0.2)
        << "the resonance is what binds here, at the corner that is 10 % higher";
    EXPECT_LT(cautious["ki_per_s"], ki_before) << "more margin, less gain";
    ki_before = cautious["ki_per_s"];
  }
}

// Tolerance: the rule holds at the frequencies of the search.
TEST_F(Tune, DesignsKeepTheSensitivityPeakAtAllCorners) {
  for (const double most : {1.4, 1.7}) {
    const json found = tuned({"--peak-sensitivity", std::to_string(most)});
    EXPECT_GE(found["candidates"].size(), 3u);
    for (const json& candidate : found["candidates"])
      EXPECT_LT(candidate["worst_margins"]["peak_sensitivity"], most + 0.02) << candidate["name"];
    EXPECT_NEAR(found["proposed"]["worst_margins"]["peak_sensitivity"], most, 0.02);
  }
}

TEST_F(Tune, ProposesTheCandidateWithTheSmallestPredictedError) {
  const json& found = tuned_once();
  const double proposed = found["proposed"]["predicted_rms_percent"];
  for (const json& candidate : found["candidates"])
    EXPECT_LE(proposed, candidate["predicted_rms_percent"]) << candidate["name"];
  EXPECT_LT(proposed, 0.10) << "present 0.193";
}

// The cautious gains are slower than the present ones.
TEST_F(Tune, ProposesThePresentSettingIfNoCandidateIsBetter) {
  const json found = tuned({"--cautious"});
  EXPECT_EQ(found["proposed"]["name"], "present");
  EXPECT_EQ(found["proposed"]["delays"], found["present"]["delays"]);
  EXPECT_NE(read("tuning.toml").find("the present setting, unchanged"), std::string::npos);
}

TEST_F(Tune, JudgesThePresentGainsByTheSameLoop) {
  const json& present = tuned_once()["present"];
  EXPECT_EQ(present["kp"], 0.05);
  EXPECT_EQ(present["ki_per_s"], 120.0);
  // tests/controller/analysis/margins_test.cpp tests the margins of the twin's true mode.
  EXPECT_NEAR(present["margins"]["phase_margin_deg"], 85.5, 1.0);
  EXPECT_NEAR(present["margins"]["gain_margin_dB"], 14.9, 1.0);
  EXPECT_LE(present["worst_margins"]["gain_margin_dB"], present["margins"]["gain_margin_dB"]);
}

TEST_F(Tune, CountsAConfiguredNotchAndLowPassInThePresentLoop) {
  const json& plain = tuned_once()["present"];
  shipped.edit("piezo.toml", "kp                 = 0.05", "measurement_filter_Hz = 200.0\nkp = 0.05");
  shipped.edit(
      "piezo.toml", "[axis.control.in_position]",
      "[axis.control.notch]\nfrequency_Hz = 450.0\ndepth = 0.1\nwidth = 0.5\n\n[axis.control.in_position]");
  const json present = tuned()["present"];
  EXPECT_EQ(present["notch"]["frequency_Hz"], 450.0);
  EXPECT_EQ(present["measurement_filter_Hz"], 200.0);
  EXPECT_LT(present["margins"]["peak_beyond_180"], 0.7 * plain["margins"]["peak_beyond_180"].get<double>());
}

// The present loop is stable on the configured plant, but not on the identified one. An unstable loop is
// neither rehearsed nor proposed.
TEST_F(Tune, ReportsThatThePresentLoopIsUnstable) {
  shipped.edit("piezo.toml", "kp                 = 0.05", "kp                 = 0.5");
  shipped.edit("piezo.toml", "resonance_Hz           = 500.0", "resonance_Hz           = 2000.0");
  shipped.edit("piezo.toml", "damping_ratio          = 0.05", "damping_ratio          = 0.7");
  shipped.edit("piezo.toml", "resonance_Hz       = 500.0", "resonance_Hz       = 310.0");
  Process program = tune();
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("NOT STABLE"), std::string::npos) << program.out();
  EXPECT_NE(program.out().find("; present setting: not stable"), std::string::npos) << program.out();
}

TEST_F(Tune, PredictsEachStructure) {
  const json& found = tuned_once();
  EXPECT_EQ(found["proposed"]["predicted"].size(), 5u);
  for (const auto& [structure, outcome] : found["proposed"]["predicted"].items())
    EXPECT_EQ(outcome["fault"], "none") << structure;
}

TEST_F(Tune, WritesThePresentValueOfEachKeyIntoTheFragment) {
  ASSERT_EQ(tune().wait(), done);
  const std::string fragment = read("tuning.toml");
  for (const char* expected : {"axis x of piezo.toml; nothing has been applied", "# was 0.05 um per um",
                               "# was 120.0\n", "# was 1000.0; one cycle", "ms of lag\n", "# was 500.0\n",
                               "# predicted RMS error", "# the prediction uses hysteresis"})
    EXPECT_NE(fragment.find(expected), std::string::npos) << expected << "\n" << fragment;
}

TEST_F(Tune, MeasuresTheChosenAxis) {
  // Two modes at equal distances below and above half the cycle rate look the same, so this stage is softer.
  const std::string shipped_text = support::read_file(shipped / "piezo.toml");
  std::ofstream(shipped / "piezo.toml")
      << std::regex_replace(shipped_text, std::regex("(resonance_Hz +)= 500\\.0"), "$1= 310.0");
  const json found = tuned({"--axis", "y", "--centre", "60", "--amplitude", "0.5"});
  EXPECT_EQ(found["axis"], "y");
  EXPECT_EQ(found["steps"]["centre"], 60.0);
  EXPECT_EQ(found["steps"]["amplitude"], 0.5);
}

TEST_F(Tune, OmitsTheMarginsOfALoopWithoutIntegral) {
  shipped.edit("piezo.toml", "ki_per_s           = 120.0", "ki_per_s           = 0.0");
  const json found = tuned();
  EXPECT_TRUE(found["present"]["margins"].is_null());
  EXPECT_GT(found["proposed"]["ki_per_s"], 0.0);
}

TEST_F(Tune, RefusesStepsOutsideTheLimitsAndInvalidRules) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> refused{
      {{"--amplitude", "51"}, "expected a drive within drive_min and drive_max, 0 and 100"},
      {{"--centre", "99.5"}, "expected a drive within drive_min and drive_max"},
      {{"--period", "0"}, "--period: 0, expected a finite number > 0"},
      {{"--axis", "z"}, "no axis z"},
      {{"--cautious", "--phase-margin", "90"}, "--phase-margin: 90"},
      {{"--cautious", "--gain-margin", "0"}, "--gain-margin: 0"},
      {{"--gain-margin", "6"}, "--gain-margin requires --cautious"},
      {{"--cautious", "--peak-sensitivity", "1.5"}, "excludes"},
      {{"--peak-sensitivity", "1"}, "--peak-sensitivity: 1"},
      {{"--plot", "bode.pdf"}, "expected a name that ends with .svg or .png"},
      {{"--interface", "vcan0"}, "excludes"}};
  for (const auto& [options, reason] : refused) {
    Process program = tune(options);
    EXPECT_EQ(program.wait(), bad_input) << options[0];
    EXPECT_NE(program.err().find(reason), std::string::npos) << program.err();
    EXPECT_FALSE(written());
  }
}

// Steps this far below the resolution of the sensor contain no information.
TEST_F(Tune, ProposesNothingFromAnInconclusiveExperiment) {
  Process program = tune({"--amplitude", "1e-6"});
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("the experiment is not conclusive"), std::string::npos) << program.err();
  EXPECT_FALSE(written());
}

// A step of 20 V moves the sample by more than position_jump_um: this sample counts as lost.
TEST_F(Tune, AcceptsARecordWithLostSamples) {
  Process program({HYSTCAN_PROGRAM, "tune", path("p733.toml"), "--rehearse", "--output", path("tuning.toml"),
                   "--amplitude", "10", "--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const json found = json::parse(program.out());
  EXPECT_GT(found["left_out"], 0);
  EXPECT_NEAR(found["natural_frequency_Hz"]["value"], 500.0, 5.0);
}

TEST_F(Tune, ReducesTheAmplitudeIfTheTwinIsNearALimit) {
  shipped.edit("piezo.toml", "position_jump_um   = 5.0", "position_jump_um   = 0.3");
  shipped.edit("piezo.toml", "frequency_Hz = 10.0", "frequency_Hz = 2.0");  // slow enough for this limit
  shipped.edit("piezo.toml", "cycles       = 10.0", "cycles       = 2.0");
  shipped.edit("piezo.toml", "rise_s       = 0.03", "rise_s       = 0.3");
  shipped.edit("piezo.toml", "transition_s = 0.1", "transition_s = 1.0");
  Process program = tune({"--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_EQ(json::parse(program.out())["steps"]["amplitude"], 0.25);
  EXPECT_NE(
      program.err().find("amplitude 0.25 V instead of 1: a larger amplitude brings the twin near a limit"),
      std::string::npos)
      << program.err();
}

TEST_F(Tune, PrintsThatASetpointEndsBeforeAnErrorCanBeMeasured) {
  std::string text = read("piezo.toml");
  const std::size_t setpoint = text.find("[[axis.control.setpoint]]");
  text.replace(setpoint, text.find("[axis.twin]") - setpoint,
               "[[axis.control.setpoint]]\nkind = \"hold\"\nlevel_um = 10.0\nduration_s = 0.001\n"
               "transition_s = 0.2\n\n");
  write("piezo.toml", text);
  Process program = tune();
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find(
                "axis x tracked, but no sample arrived after the settling time of a reference segment. "
                "[[axis.control.setpoint]] ends before an error can be measured: make the reference longer"),
            std::string::npos)
      << program.err();
  EXPECT_FALSE(written());
}

TEST_F(Tune, WritesNothingAfterAFault) {
  shipped.edit("piezo.toml", "position_max_um    = 34.0", "position_max_um    = 12.0");
  shipped.edit("piezo.toml", "cycles       = 10.0", "cycles       = 1.0");
  Process program = tune({"--centre", "60"});
  EXPECT_NE(program.wait(), done);
  EXPECT_FALSE(written());
}

}  // namespace
}  // namespace hystcan::tune_test
