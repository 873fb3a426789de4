// `hystcan init` with records of stages whose hysteresis differs in kind from the model (../stages).
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <ostream>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "config/document/toml_edit.h"
#include "config/files/model_file.h"
#include "model/hysteresis.h"
#include "model/hysteresis_parameters.h"
#include "tests/app/command_line/cli.h"

namespace hystcan::foreign_stages_test {
namespace {

using Words = std::vector<std::string>;

const std::string records = HYSTCAN_SOURCE_DIR "/tests/app/stages/";

const Words of_quant60{"--step",      records + "quant60_step.csv",
                       "--drive-min", "0",
                       "--drive-max", "100",
                       "--safe",      "0",
                       "--stroke",    "60"};
const Words of_creep30{"--drive-min", "-20",      "--drive-max", "120",         "--safe",
                       "0",           "--stroke", "28",          "--resonance", "250"};

struct ForeignStage {
  const char* name;
  double stroke_um;  ///< true value
  Words facts;
};
void PrintTo(const ForeignStage& stage, std::ostream* stream) { *stream << stage.name; }

class InitOfForeignStages : public Cli, public testing::WithParamInterface<ForeignStage> {};

// Both records begin with wiped memory at the lowest drive: no row shows the curve of an empty memory. A free
// curve began 32 and 162 um below the stage, and so did the twin of the rehearsal.
TEST_P(InitOfForeignStages, EndsWithAPlausibleCurveAndStroke) {
  Words words{HYSTCAN_PROGRAM, "init", path("stage"), "--record", records + GetParam().name + "_loops.csv",
              "--yes"};
  words.insert(words.end(), GetParam().facts.begin(), GetParam().facts.end());
  Process init(words);
  ASSERT_EQ(init.wait(), done) << init.err();
  EXPECT_EQ(init.out().find(" 0 um"), std::string::npos) << init.out();
  const model::HysteresisParameters found = config::load_model(shipped / "stage/x.model.toml");
  const double stroke_um = GetParam().stroke_um;
  EXPECT_NEAR(found.output_range().span(), stroke_um, 0.05 * stroke_um);
  const double below_um = found.lower_point().level - found.ascending.value(found.input_range().lo);
  EXPECT_GE(below_um, -1e-9 * stroke_um);  // rounding: the chosen curve begins at the lower point
  EXPECT_LT(below_um, 0.25 * stroke_um);
  const auto creep = config::load_lag(shipped / "stage/x.model.toml").creep,
             twins = config::load_lag(shipped / "stage/x.plant.toml").creep;
  ASSERT_TRUE(creep && twins);
  EXPECT_GT(twins->per_decade, creep->per_decade);
  EXPECT_LT(twins->per_decade, 1.7 * creep->per_decade);
  const model::Hysteresis twin(config::load_model(shipped / "stage/x.plant.toml"));
  model::HysteresisState wiped = twin.at_lower_threshold();
  EXPECT_NEAR(twin.virgin(0.0).output, twin.advance(wiped, 0.0).value, 1e-6)
      << "the twin starts where the record began";
  EXPECT_NE(read("stage/x.report/report.html").find("the ascending reference curve is chosen"),
            std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(, InitOfForeignStages,
                         testing::Values(ForeignStage{"quant60", 58.5, of_quant60},
                                         ForeignStage{"creep30", 27.7, of_creep30}),
                         [](const auto& test) { return test.param.name; });

// quant60.plant.toml was fitted to the record without hystcan; README.txt states the rest of the stage.
TEST_F(Cli, InitKeepsItsPromiseOnAPreisachPlaneOfTheRecord) {
  Words words{HYSTCAN_PROGRAM, "init", path("stage"), "--record", records + "quant60_loops.csv", "--yes"};
  words.insert(words.end(), of_quant60.begin(), of_quant60.end());
  Process init(words);
  ASSERT_EQ(init.wait(), done) << init.err();
  const std::regex line(R"(promise x: [0-9.]+ um RMS true \(90 %: ([0-9.]+) to ([0-9.]+)\).*; cautious)");
  std::smatch promise;
  const std::string text = init.out();
  ASSERT_TRUE(std::regex_search(text, promise, line)) << text;
  std::filesystem::copy_file(records + "quant60.plant.toml", shipped / "stage/quant60.plant.toml");
  config::TomlEdit edit = config::TomlEdit::of_file(shipped / "stage/stage.toml");
  const std::string twin = "axis[0].twin.";
  for (const auto& [key, value] : {std::pair{"model", "\"quant60.plant.toml\""},
                                   {"resonance_Hz", "260.0"},
                                   {"damping_ratio", "0.03"},
                                   {"bandwidth_Hz", "500.0"},
                                   {"sensor.delay_us", "300.0"},
                                   {"creep.per_decade", "0.01"},
                                   {"creep.from_s", "0.03"},
                                   {"creep.to_s", "300.0"}})
    edit.set(twin + key, value);
  write("stage/true.toml", edit.text());
  Process demo(
      {HYSTCAN_PROGRAM, "demo", "--config", path("stage/true.toml"), "--json", "--output", path("demo")});
  ASSERT_EQ(demo.wait(), done) << demo.err();
  const nlohmann::json columns = nlohmann::json::parse(demo.out())["columns"];
  const auto loop = std::ranges::find(columns, "inverse+pi", [](const auto& of) { return of["structure"]; });
  ASSERT_NE(loop, columns.end());
  const double came_um = (*loop)["true"]["rms_um"];
  EXPECT_LE(std::stod(promise[1]), came_um);
  EXPECT_GE(std::stod(promise[2]), came_um);
}

TEST_F(Cli, InitUsesCurvesOrderAndCreepOfTheModel) {
  Words words{HYSTCAN_PROGRAM, "init", path("stage"), "--record", records + "creep30_loops.csv"};
  words.insert(words.end(), of_creep30.begin(), of_creep30.end());
  words.insert(words.end(), {"--order", "3", "--creep", "0.03", "--curves", "polynomial", "--yes"});
  Process init(words);
  ASSERT_EQ(init.wait(), done) << init.err();
  EXPECT_NE(init.out().find("x: hysteresis: order 3, "), std::string::npos) << init.out();
  EXPECT_NE(read("stage/x.model.toml").find("creeps by 3 % of its travel"), std::string::npos);
}

TEST_F(Cli, InitContinueExplainsAFolderThatIsComplete) {
  std::filesystem::create_directory(shipped / "stage");
  write("stage/stage.toml", "format = 1\n");
  Process init({HYSTCAN_PROGRAM, "init", path("stage"), "--continue"});
  EXPECT_EQ(init.wait(), bad_input);
  EXPECT_NE(init.err().find("was created with --record"), std::string::npos) << init.err();
  EXPECT_NE(init.err().find("hystcan demo --config"), std::string::npos) << init.err();
}

}  // namespace
}  // namespace hystcan::foreign_stages_test
