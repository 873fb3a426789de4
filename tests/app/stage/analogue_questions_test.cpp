// The questions of `hystcan init` about an analogue amplifier, and the written files.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/stage/first_stage.h"
#include "app/stage/stage_questions.h"
#include "config/files/model_file.h"
#include "tests/support/refusal.h"
#include "tests/support/scratch.h"

namespace hystcan::app::analogue_questions_test {
namespace {

/// Everything is stated except the values that the tests enter.
InitOptions stated() {
  InitOptions options;
  options.axes = {"x", "y"};
  options.drive_unit = "V";
  options.interface = "vcan0";
  options.drive_min = {0.0};
  options.drive_max = {100.0};
  options.safe_drive = {0.0};
  options.stroke_um = {30.0};
  options.sensor_at_safe_um = {0.0};
  options.resonance_Hz = {500.0};
  options.damping_ratio = {0.02};
  options.sensor_delay_us = {0.0};
  options.rate_Hz = 1000.0;
  options.nodes = {1, 2, 3, 4};
  return options;
}

StageFacts answered(const InitOptions& options, const std::string& answers) {
  std::istringstream in(answers);
  Questions questions(in, true);
  return ask_about(options, {}, questions);
}

TEST(AnalogueQuestions, AreSkippedForNodesOnCan) {
  InitOptions options = stated();
  options.card = "can";
  options.dbc = "hystcan.dbc";
  EXPECT_FALSE(answered(options, "").axes[0].config.analogue);
}

TEST(AnalogueQuestions, RequestCardAndScalesOnceForAllAxes) {
  const StageFacts facts = answered(stated(), "comedi:/dev/comedi0\n\n3.5\n");
  for (const unsigned i : {0u, 1u}) {
    const node::AnalogueConfig& analogue = *facts.axes[i].config.analogue;
    EXPECT_EQ(analogue.device, "comedi:/dev/comedi0");
    EXPECT_EQ(analogue.drive_output.subdevice, 1u);
    EXPECT_EQ(analogue.drive_output.channel, i);
    EXPECT_EQ(analogue.position_input.place.channel, i);
    EXPECT_EQ(analogue.volts_per_drive, 0.1);
    EXPECT_EQ(analogue.position_um_per_V, 3.5);
  }
}

TEST(AnalogueQuestions, UseTheScaleOfTheRecord) {
  InitOptions options = stated();
  options.input.layout.output_scale = 12.5;
  EXPECT_EQ(answered(options, "simulated\n\n\n").axes[0].config.analogue->position_um_per_V, 12.5);
}

TEST(AnalogueQuestions, AreRepeatedAfterAnInvalidAnswer) {
  const StageFacts facts = answered(stated(), "nidaq:0\nsimulated:99\nsimulated\n0\n0.09\n3\n");
  EXPECT_EQ(facts.axes[0].config.analogue->device, "simulated");
  EXPECT_EQ(facts.axes[0].config.analogue->volts_per_drive, 0.09);
}

TEST(AnalogueQuestions, NameAMissingOptionWithoutADefault) {
  InitOptions options = stated();
  options.card = "simulated";
  std::istringstream none;
  Questions questions(none, false);
  const std::string refusal = support::refusal_of([&] { ask_about(options, {}, questions); });
  EXPECT_TRUE(refusal.starts_with("--um-per-V is missing")) << refusal;
}

TEST(AnalogueConfigText, ContainsTheAnswers) {
  StageFacts facts = answered(stated(), "comedi:/dev/comedi0\n0.09\n3.3\n");
  const support::ScratchFolder folder;
  std::filesystem::copy(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc", folder.path());
  for (AxisFacts& axis : facts.axes) {
    axis.config.control_model = "model.toml";
    axis.config.twin_model = "plant.toml";
  }
  std::ofstream(folder / "model.toml") << config::model_text(straight_line(facts.axes[0]), {});
  std::ofstream(folder / "plant.toml") << config::model_text(usual_loop(facts.axes[0]), {});
  const std::string text = config_text(facts);
  EXPECT_NE(text.find("hystcan node FILE"), std::string::npos) << text;
  std::ofstream(folder / "stage.toml") << text;
  const auto axes = analogue_axes(config::load(folder / "stage.toml"));
  ASSERT_EQ(axes.size(), 2u);
  EXPECT_EQ(axes[1].config.drive_output.channel, 1u);
  EXPECT_EQ(axes[1].config.volts_per_drive, 0.09);
  EXPECT_EQ(axes[1].config.position_um_per_V, 3.3);
}

}  // namespace
}  // namespace hystcan::app::analogue_questions_test
