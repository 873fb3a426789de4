#include "tests/app/command_line/any_stage.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/long_run.h"

namespace hystcan::any_stage_test {
namespace {

std::string number(double value) {
  const std::string text = std::to_string(value);  // with a point, as TOML has floats
  return text;
}

}  // namespace

std::string Stage::text() const {
  char line[200];
  std::snprintf(line, sizeof line,
                "%4.0f Hz, mode %.2f of it, damping %.3f, amplifier %4.0f Hz, sensor %3.0f us", rate_Hz,
                mode_Hz / rate_Hz, damping_ratio, amplifier_Hz, sensor_delay_us);
  return line;
}

Stage drawn(Draw& draw) {
  Stage stage{};
  stage.rate_Hz = 500.0 * std::floor(1.0 + 3.0 * draw.part());
  stage.mode_Hz = stage.rate_Hz * 0.1 * std::pow(20.0, draw.part());
  stage.damping_ratio = 0.01 * std::pow(10.0, draw.part());
  stage.amplifier_Hz = 300.0 * std::pow(10.0, draw.part());
  stage.sensor_delay_us = std::max(0.0, std::round(600.0 * (2.0 * draw.part() - 1.0)));
  stage.noise_um = 0.0005 * std::pow(10.0, draw.part());
  stage.creep_per_decade = 0.02 * draw.part();
  return stage;
}

std::string configured(config::TomlEdit edit, const Stage& stage, Draw& draw) {
  const double resonance_Hz = stage.mode_Hz * draw.off(), damping_ratio = stage.damping_ratio * draw.off();
  const std::string control = "axis[0].control.", delays = control + "delays.", twin = "axis[0].twin.";
  edit.comment_out(control + "notch");
  edit.set("controller.rate_Hz", number(stage.rate_Hz));
  edit.set(control + "ki_per_s",
           number(std::min(3.14159 * damping_ratio * resonance_Hz, 0.1 * stage.rate_Hz)));
  edit.set(delays + "second_order", "false");
  edit.set(delays + "command_delay_us", number(std::round(1e6 / stage.rate_Hz)));
  edit.set(delays + "amplifier_bandwidth_Hz", number(stage.amplifier_Hz * draw.off()));
  edit.set(delays + "resonance_Hz", number(resonance_Hz));
  edit.set(delays + "damping_ratio", number(damping_ratio));
  edit.set(twin + "resonance_Hz", number(stage.mode_Hz));
  edit.set(twin + "damping_ratio", number(stage.damping_ratio));
  edit.set(twin + "bandwidth_Hz", number(stage.amplifier_Hz));
  edit.set(twin + "noise_um_rms", number(stage.noise_um));
  edit.set(twin + "sensor.delay_us", number(stage.sensor_delay_us));
  edit.set(twin + "creep.per_decade", number(stage.creep_per_decade));
  edit.set(twin + "creep.from_s", "0.1");
  edit.set(twin + "creep.to_s", "100.0");
  return edit.text();
}

Seeds seeds(unsigned usual) {
  if (const char* alone = std::getenv("HYSTCAN_STAGE")) {
    const auto seed = static_cast<unsigned>(std::stoul(alone));
    return {seed, seed};
  }
  return {1, support::long_run() ? 200 : usual};
}

Errors errors_of(const config::Config& config, twin::Config stage, double resonance) {
  stage.axes[0].axis.plant.mode.natural_frequency_Hz *= resonance;
  const rehearsal::Outcome outcome = rehearsal::run_once(app::rehearsal_setup(config, stage), app::settle_s,
                                                         [](const controller::CycleRecord&) {});
  const controller::AxisOutcome& axis = outcome.axes[0];
  return {axis.statistics.total().rms_um(), outcome.true_errors[0].total().rms_um(), axis.stroke_um,
          axis.fault.cause != controller::Cause::none};
}

bool faults(const config::Config& config, const twin::Config& stage) {
  return errors_of(config, stage, 0.9).faulted || errors_of(config, stage).faulted ||
         errors_of(config, stage, 1.1).faulted;
}

void print_shares(const char* what, std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  std::printf("%-40s median %.3f, 90 %% %.3f, worst %.3f\n", what, at(0.5), at(0.9), at(1.0));
}

}  // namespace hystcan::any_stage_test
