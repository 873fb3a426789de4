// The output of `hystcan tune`: whole configurations, tables, pictures.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/command_line/cli.h"
#include "tests/support/long_run.h"

namespace hystcan::tune_files_test {
namespace {

using nlohmann::json;

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

class TuneFiles : public Cli {
 protected:
  Process tune(const char* config, const std::vector<std::string>& more) const {
    std::vector<std::string> words{HYSTCAN_PROGRAM, "tune",     path(config),
                                   "--rehearse",    "--output", path("tuning.toml")};
    words.insert(words.end(), more.begin(), more.end());
    return Process(words);
  }
  json written(const char* config, std::vector<std::string> more = {}) const {
    for (const std::string& word : {std::string("--write"), path("new.toml"), std::string("--json")})
      more.push_back(word);
    Process program = tune(config, more);
    EXPECT_EQ(program.wait(), done) << program.err();
    return json::parse(program.out());
  }
  void expect_checks(const char* config) const {
    Process check({HYSTCAN_PROGRAM, "check", path(config)});
    EXPECT_EQ(check.wait(), done) << config << ": " << check.err();
  }
  /// For the first axis with inverse+pi in the demo.
  json demonstrated(const char* config) const {
    Process demo({HYSTCAN_PROGRAM, "demo", "--config", path(config), "--output", path("demo"), "--json"});
    EXPECT_EQ(demo.wait(), done) << demo.err();
    return json::parse(demo.out())["columns"].back();
  }
  /// RMS error of the first segment of the reference, % of stroke.
  double triangle_rms_percent(const char* config) const {
    return demonstrated(config)["segments"][0]["rms_percent"].get<double>();
  }
};

TEST_F(TuneFiles, WritesAConfigurationThatRunsAtOnceAndTracksAsPredicted) {
  const json found = written("piezo.toml");
  expect_checks("new.toml");
  EXPECT_NEAR(demonstrated("new.toml")["rms_percent"], found["proposed"]["predicted_rms_percent"], 0.02);
}

// A manual setting with a notch and a ki of 200 gave 0.11 and 0.30; a ki of 15 alone gives 0.70 and 3.96.
TEST_F(TuneFiles, TracksATriangleOnTheSoftStageAsWellAsASettingByHand) {
  shipped.edit("soft_stage.toml", "ki_per_s           = 214.0", "ki_per_s           = 15.0");
  shipped.edit("soft_stage.toml", "depth        = 0.04", "depth        = 1.0");  // nothing is filtered
  const json found = written("soft_stage.toml");
  EXPECT_FALSE(found["proposed"]["notch"].is_null());
  EXPECT_LE(triangle_rms_percent("new.toml"), 0.12) << "10 Hz";
  shipped.edit("new.toml", "frequency_Hz = 10.0", "frequency_Hz = 20.0");
  EXPECT_LE(triangle_rms_percent("new.toml"), 0.30) << "20 Hz";
}

// docs/tracking.md describes the remaining error at 10 Hz.
TEST_F(TuneFiles, TracksATriangleOfTwentyHertzOnTheGalfenolStage) {
  shipped.edit("galfenol.toml", "frequency_Hz = 5.0", "frequency_Hz = 20.0");
  const json found = written("galfenol.toml");
  EXPECT_FALSE(found["proposed"]["notch"].is_null());
  constexpr double travel_um = 100.0;  // the triangle covers 80 % of it
  EXPECT_LE(100.0 * demonstrated("new.toml")["segments"][0]["rms_um"].get<double>() / travel_um, 0.30);
}

TEST_F(TuneFiles, ChangesOnlyTheLinesOfTheProposalInTheConfiguration) {
  const json found = written("piezo.toml", {"--axis", "y"});
  const std::vector<std::string> before = lines_of(read("piezo.toml")), after = lines_of(read("new.toml"));
  const std::size_t second =
      static_cast<std::size_t>(std::ranges::find(before, "name           = \"y\"") - before.begin());
  std::size_t at = 0, changed = 0;
  for (std::size_t line = 0; line < before.size(); ++line) {
    while (at < after.size() && after[at] != before[line] && at < line + 12 &&
           std::find(after.begin() + static_cast<long>(at), after.end(), before[line]) != after.end() &&
           line > second)
      ++at;
    if (at < after.size() && after[at] == before[line])
      ++at;
    else
      ++changed;
  }
  EXPECT_LE(changed, 5u) << "kp, ki, amplifier, resonance, damping";
  EXPECT_LE(after.size(), before.size() + 6);
  EXPECT_TRUE(std::equal(before.begin(), before.begin() + static_cast<long>(second), after.begin()))
      << "axis x is unchanged";
  EXPECT_GT(found["proposed"]["ki_per_s"], 120.0);
}

TEST_F(TuneFiles, CommentsOutANotchMissingInTheProposal) {
  shipped.edit("piezo.toml", "ki_per_s           = 409.0",
               "ki_per_s           = 100.0");  // stable with this notch
  shipped.edit("piezo.toml", "[axis.control.in_position]",
               "[axis.control.notch]   # mine\nfrequency_Hz = 60.0\ndepth = 0.1\nwidth = "
               "1.0\n\n[axis.control.in_position]");
  const json found = written("piezo.toml");
  ASSERT_TRUE(found["proposed"]["notch"].is_null()) << found["proposed"];
  EXPECT_NE(read("new.toml").find("# [axis.control.notch]   # mine\n# frequency_Hz = 60.0\n"),
            std::string::npos);
  expect_checks("new.toml");
}

TEST_F(TuneFiles, WritesANotchAndASecondOrderPreviewIntoTheConfiguration) {
  shipped.edit("galfenol.toml", "damping_ratio          = 0.06", "damping_ratio          = 0.02");
  const json found = written("galfenol.toml");
  expect_checks("new.toml");
  EXPECT_EQ(found["proposed"]["delays"]["second_order"],
            read("new.toml").find("second_order") != std::string::npos);
  EXPECT_EQ(!found["proposed"]["notch"].is_null(),
            read("new.toml").find("\n[axis.control.notch]\n") != std::string::npos);
}

TEST_F(TuneFiles, RefusesToWriteOverAnyFile) {
  const std::string before = read("raster.toml");
  Process program = tune("piezo.toml", {"--write", path("raster.toml")});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("exists already, expected a new file"), std::string::npos) << program.err();
  EXPECT_EQ(read("raster.toml"), before);
}

TEST_F(TuneFiles, RefusesToWriteIntoAnotherFolder) {
  EXPECT_EQ(tune("piezo.toml", {"--write", "/tmp/elsewhere.toml"}).wait(), bad_input);
  EXPECT_FALSE(std::filesystem::exists(shipped / "tuning.toml"));
}

TEST_F(TuneFiles, ProposesAndWritesForEachShippedConfiguration) {
  for (const auto& entry : std::filesystem::directory_iterator(shipped.folder())) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(".toml") || read(name.c_str()).find("[[axis]]") == std::string::npos) continue;
    if (!support::long_run() && name != "galfenol.toml" && name != "lab_amplifier.toml") continue;
    const json found = written(name.c_str());
    EXPECT_LE(found["proposed"]["predicted_rms_percent"], found["present"]["predicted_rms_percent"]) << name;
    EXPECT_LT(found["proposed"]["worst_margins"]["peak_sensitivity"], 1.75) << name;
    const json &truth = found["proposed"]["predicted_true_rms_percent"],
               &before = found["present"]["predicted_true_rms_percent"];
    EXPECT_TRUE(before.is_null() || truth <= before) << name << ' ' << truth;
    expect_checks("new.toml");
    std::filesystem::remove(shipped / "new.toml");
    std::filesystem::remove(shipped / "tuning.toml");
  }
}

TEST_F(TuneFiles, TabulatesMeasuredPointsModelAndLoops) {
  Process program = tune("galfenol.toml", {"--response", path("response.csv")});
  ASSERT_EQ(program.wait(), done) << program.err();
  const std::vector<std::string> rows = lines_of(read("response.csv"));
  EXPECT_EQ(rows[0].substr(0, 50), "frequency_Hz,measured_gain,measured_phase_deg,cohe");
  EXPECT_GT(rows.size(), 100u);
  for (const std::string& row : rows) EXPECT_EQ(std::ranges::count(row, ','), 11) << row;
  // At a third of the resonance of 300 Hz the plant has a gain of 1 / (1 - 1/9).
  const auto near_100_Hz = std::ranges::find_if(
      rows, [](const std::string& row) { return row.starts_with("10") && row[3] == '.'; });
  ASSERT_NE(near_100_Hz, rows.end());
  std::istringstream cells(*near_100_Hz);
  double frequency_Hz = 0.0, measured = 0.0, phase = 0.0, coherence = 0.0, model = 0.0;
  char comma = 0;
  cells >> frequency_Hz >> comma >> measured >> comma >> phase >> comma >> coherence >> comma >> model;
  EXPECT_NEAR(measured, 1.125, 0.1);
  EXPECT_NEAR(model, 1.125, 0.05);
  EXPECT_GT(coherence, 0.95);
}

TEST_F(TuneFiles, DrawsAPictureAndKeepsItsData) {
  Process program = tune("galfenol.toml", {"--plot", path("bode.svg")});
  ASSERT_EQ(program.wait(), done) << program.err();
  for (const char* name : {"bode.svg", "bode.data.csv", "bode.json"})
    EXPECT_TRUE(std::filesystem::exists(shipped / name)) << name << program.err();
}

}  // namespace
}  // namespace hystcan::tune_files_test
