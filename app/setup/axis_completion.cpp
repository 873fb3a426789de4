#include "app/setup/axis_completion.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "app/io/exit_status.h"
#include "app/io/output_file.h"
#include "app/io/progress.h"
#include "app/io/standard_streams.h"
#include "app/live/rehearsal_setup.h"
#include "app/live/stop_signal.h"
#include "app/report/config_edit.h"
#include "app/report/dynamics_text.h"
#include "app/report/identification_findings.h"
#include "app/report/identification_report.h"
#include "app/report/identification_result.h"
#include "app/report/report.h"
#include "app/setup/first_models.h"
#include "app/setup/tuning.h"
#include "config/document/toml_edit.h"
#include "config/files/model_file.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {
namespace {

using identification::Dataset;
using identification::Identified;

void stop_if_signalled() {
  if (stop_signalled != 0) throw RunError("stopped, nothing is written");
}

Identified identified_loops(const AxisRecords& records) {
  Progress progress("identifying", 0, "trials");
  identification::IdentifyOptions asked;
  asked.observed_thresholds = true;  // so that the start-up reaches both
  asked.go_on = [&progress, tries = std::uint64_t{0}]() mutable {
    progress.update(++tries);
    return stop_signalled == 0;
  };
  try {
    return identification::identify(records.loops, asked);
  } catch (const std::invalid_argument& error) {
    throw config::Error(fmt::format("{}: {}", fmt::join(records.names(), ", "), error.what()));
  }
}

/// Empty, or why the report has no pictures.
std::string write_axis_report(const std::filesystem::path& folder, const AxisRecords& records,
                              const Identified& found, const std::vector<std::string>& said) {
  Progress progress("comparing models", 0, "trials");
  return write_report(folder, {records.loops, records.names(), found, said},
                      [&progress, tries = std::uint64_t{0}]() mutable {
                        progress.update(++tries);
                        return stop_signalled == 0;
                      })
      .undrawn;
}

std::string validation_line(const model::HysteresisParameters& parameters, double delay_s,
                            const AxisRecords& records) {
  const Validation seen =
      validate(model::Hysteresis(parameters), *records.unseen,
               {.lag = {.delay_s = delay_s, .dynamics = {}}, .estimate_s = {}, .memory = {}});
  return fmt::format("unseen: {} is predicted with {:.3g} % RMS, {:.3g} % at most",
                     records.files.unseen->filename().string(), 100.0 * seen.all.rms / seen.output_span,
                     100.0 * seen.all.max / seen.output_span);
}

/// The mode behind the record, as delays of the controller; a cautious loop for it, which is stable with them.
LoopKeys measured_keys(const Dataset& record, const config::Config& config) {
  const double cycle_s = 1.0 / config.controller.rate_Hz;
  IdentifiedPlant plant =
      identified_plant(record, identification::fit_second_order(record), config.axes[0].control.delays);
  plant.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 * cycle_s));
  const controller::LoopConfig loop{.delays = plant.delays, .cycle_s = cycle_s};
  return {{.pi = controller::largest_gains(loop, controller::CautiousRule{})}, plant.delays};
}

/// The measured mode in [axis.control] and in [axis.twin].
void set_dynamics(const std::filesystem::path& file, std::size_t i, const LoopKeys& keys) {
  write_file(file, with_loop_keys(config::load(file), i, keys));
  config::TomlEdit text = config::TomlEdit::of_file(file);
  const std::string twin = fmt::format("axis[{}].twin.", i);
  text.set(twin + "resonance_Hz", toml_number(keys.delays.resonance_Hz));
  text.set(twin + "damping_ratio", toml_number(keys.delays.damping_ratio));
  text.set(twin + "bandwidth_Hz", toml_number(keys.delays.amplifier_bandwidth_Hz));
  write_file(file, text.text());
}

std::string dynamics_line(const std::string& from, const controller::Delays& delays) {
  return fmt::format("dynamics: {:.5g} Hz, damping ratio {:.3g}, amplifier {:.4g} Hz; from {}",
                     delays.resonance_Hz, delays.damping_ratio, delays.amplifier_bandwidth_Hz, from);
}

std::string loop_line(const TuningReport& report) {
  const Candidate& best = report.proposed();
  std::string text = fmt::format("loop: {}, kp {:.4g}, ki {:.4g} 1/s", best.name, best.setting.pi.kp,
                                 best.setting.pi.ki_per_s);
  if (best.setting.measurement_filter_Hz > 0.0)
    text += fmt::format(", low pass {:g} Hz", best.setting.measurement_filter_Hz);
  if (best.setting.notch) text += fmt::format(", notch at {:.5g} Hz", best.setting.notch->frequency_Hz);
  if (best.loop)
    text += fmt::format("; sensitivity at most {:.3g}, {:.3g} with the resonance {:g} % off",
                        best.loop->margins.peak_sensitivity, best.loop->worst.peak_sensitivity,
                        report.rule.resonance_percent);
  return text;
}

}  // namespace

std::string model_name(const std::string& axis) { return axis + ".model.toml"; }
std::string plant_name(const std::string& axis) { return axis + ".plant.toml"; }

IdentifiedAxis identify_axis(const std::filesystem::path& folder, const std::string& axis,
                             const AxisRecords& records) {
  const Identified found = identified_loops(records);
  stop_if_signalled();
  const std::vector<std::string> said = findings(records.loops, found);
  write_file(folder / model_name(axis), identified_model_text(found, said));
  write_file(folder / plant_name(axis),
             "# The twin's actuator: the identified model with curves 3 % and k 20 % off.\n" +
                 config::model_text(not_quite(found.parameters), {}));
  const std::string undrawn = write_axis_report(folder / (axis + ".report"), records, found, said);
  stop_if_signalled();
  IdentifiedAxis result{
      .parameters = found.parameters, .noise_um = found.datasets.front().noise, .lines = {}};
  const double percent = 100.0 / found.output_span;
  result.lines.push_back(fmt::format(
      "hysteresis: {}, misses {} by {:.3g} % RMS{} of {:.5g} um; {}.report/report.html{}",
      found.search.shape.text(), fmt::join(records.names(), ", "), found.overall.rms * percent,
      found.held_out_rms ? fmt::format(" ({:.3g} % held out)", *found.held_out_rms * percent) : "",
      found.output_span, axis, undrawn.empty() ? "" : ", without pictures: " + undrawn));
  if (records.unseen) result.lines.push_back(validation_line(found.parameters, found.delay_s, records));
  return result;
}

std::vector<std::string> tune_axis(const std::filesystem::path& config_file, std::size_t i,
                                   const AxisRecords& records) {
  std::vector<std::string> lines;
  const std::string name = config::load(config_file).axes[i].wire.name;
  const OpenLoopOptions rehearsed{.config = config_file, .axis = name, .interface = {}, .rehearse = true};
  if (records.step) {
    LoopKeys keys;
    try {
      keys = measured_keys(*records.step, chosen_axis_of(config::load(config_file), rehearsed));
    } catch (const std::invalid_argument& error) {
      throw config::Error(fmt::format("{}: {}", records.files.step->string(), error.what()));
    }
    set_dynamics(config_file, i, keys);
    lines.push_back(dynamics_line(records.files.step->filename().string(), keys.delays));
  }
  const config::Config loaded = config::load(config_file), config = chosen_axis_of(loaded, rehearsed);
  if (!records.step)
    lines.push_back(dynamics_line("what was stated, not measured", config.axes[0].control.delays));
  const twin::Config twin = twin_config(loaded);
  const CandidateRules rules{};
  TuningReport report =
      tuning_of(config, with_safe_amplitude(usual_steps(config.axes[0].control.gate), config, twin), rules,
                !records.step);
  const Dataset record = records.step ? *records.step : measured_steps(config, twin, rehearsed, report.steps);
  evaluate(report, record, config, twin, rules);
  stop_if_signalled();
  const Candidate& best = report.proposed();
  LoopKeys keys{best.setting, best.delays};
  if (!records.step) {  // of the plant, only what was stated is known
    const controller::Delays& stated = config.axes[0].control.delays;
    keys.delays = stated;
    keys.delays.second_order = best.delays.second_order;
    keys.delays.plant_inverse = best.delays.plant_inverse;
  }
  write_file(config_file, with_loop_keys(loaded, i, keys));
  lines.push_back(loop_line(report));
  if (const std::string undrawn =
          draw(response_of(report, record), config_file.parent_path() / (name + ".bode.svg"));
      !undrawn.empty())
    lines.push_back("no picture of the loop: " + undrawn);
  return lines;
}

std::vector<std::string> rehearsal_of(const config::Config& config) {
  const rehearsal::Outcome outcome = rehearsal::run_once(
      rehearsal_setup(config), settle_s, [](const controller::CycleRecord&) { stop_if_signalled(); });
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < outcome.axes.size(); ++i) {
    const controller::AxisOutcome& axis = outcome.axes[i];
    if (axis.fault.cause != controller::Cause::none)
      throw RunError(fmt::format("the rehearsal ended: {}", describe(axis.name, axis.fault)));
    const controller::ErrorStatistics error = axis.statistics.total(), truth = outcome.true_errors[i].total();
    lines.push_back(fmt::format(
        "{}: rehearsal: RMS error {:.3g} um, {:.3g} % of {:.4g} um; at most {:.3g} um; the true one, of the stage itself, "
        "{:.3g} um, {:.3g} %",
        axis.name, error.rms_um(), 100.0 * error.rms_um() / axis.stroke_um, axis.stroke_um, error.max_um,
        truth.rms_um(), 100.0 * truth.rms_um() / axis.stroke_um));
  }
  return lines;
}

}  // namespace hystcan::app
