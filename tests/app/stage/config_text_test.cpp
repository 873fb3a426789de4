#include <gtest/gtest.h>

#include <fstream>

#include "app/live/rehearsal_setup.h"
#include "app/stage/first_stage.h"
#include "config/files/model_file.h"
#include "config/schema/check.h"
#include "config/schema/config.h"
#include "config/schema/setpoint_warnings.h"
#include "tests/support/scratch.h"

namespace hystcan::app::config_text_test {
namespace {

struct Stage {
  const char* name;
  double drive_min, drive_max, safe_drive, stroke_um, resonance_Hz, damping_ratio, rate_Hz;
};

void PrintTo(const Stage& stage, std::ostream* out) { *out << stage.name; }

/// A folder with the configuration of the stage and its first models.
class FirstConfiguration : public testing::TestWithParam<Stage> {
 protected:
  FirstConfiguration() {
    const Stage& stage = GetParam();
    StageFacts facts;
    facts.config.controller.rate_Hz = stage.rate_Hz;
    facts.config.bus.dbc = "hystcan.dbc";
    AxisFacts& axis = facts.axes.emplace_back();
    axis.config.wire = {
        .name = "x", .message_prefix = "X", .amplifier_node = 1, .sensor_node = 2, .drive_unit = "V"};
    axis.config.control.gate = {
        .drive_min = stage.drive_min, .drive_max = stage.drive_max, .safe_drive = stage.safe_drive};
    const double below =
        stage.stroke_um * (stage.safe_drive - stage.drive_min) / (stage.drive_max - stage.drive_min);
    axis.travel_um = {-below, stage.stroke_um - below};
    axis.config.control.delays.resonance_Hz = stage.resonance_Hz;
    axis.config.control.delays.damping_ratio = stage.damping_ratio;
    axis.config.twin.sensor.noise_um_rms = 1e-5 * stage.stroke_um;
    axis.config.control_model = "model.toml";
    axis.config.twin_model = "plant.toml";
    std::filesystem::copy(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc", folder.path());
    std::ofstream(folder / "model.toml") << config::model_text(straight_line(axis), {});
    std::ofstream(folder / "plant.toml") << config::model_text(usual_loop(axis), {});
    std::ofstream(folder / "stage.toml") << config_text(facts);
  }
  const support::ScratchFolder folder;
};

TEST_P(FirstConfiguration, IsReadWithoutWarnings) {
  const config::Config config = config::load(folder / "stage.toml");
  EXPECT_EQ(config::setpoint_warnings(config), std::vector<std::string>());
  EXPECT_EQ(config::supervision_warnings(config), std::vector<std::string>());
  for (const config::Finding& finding : config::findings_of_loop(config.axes[0], config.controller.rate_Hz))
    EXPECT_FALSE(finding.is_warning) << finding.text;
}

TEST_P(FirstConfiguration, TracksTheTwinWithoutAFault) {
  const config::Config config = config::load(folder / "stage.toml");
  const auto outcome = rehearsal::run_once(rehearsal_setup(config), 0.1, [](const auto&) {});
  EXPECT_EQ(outcome.axes[0].fault.cause, controller::Cause::none);
  EXPECT_GT(outcome.axes[0].statistics.total().samples, 0u);
}

INSTANTIATE_TEST_SUITE_P(Stages, FirstConfiguration,
                         testing::Values(Stage{"piezo", 0.0, 100.0, 0.0, 30.0, 500.0, 0.05, 1000.0},
                                         Stage{"symmetric", -75.0, 75.0, 0.0, 12.0, 300.0, 0.02, 1000.0},
                                         Stage{"soft", -20.0, 120.0, 0.0, 100.0, 20.0, 0.02, 200.0},
                                         Stage{"stiff", 0.0, 150.0, 75.0, 5.0, 4000.0, 0.01, 1500.0},
                                         Stage{"slow", 0.0, 1000.0, 0.0, 1000.0, 35.0, 0.02, 100.0}),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace hystcan::app::config_text_test
