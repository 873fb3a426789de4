#include "app/stage/axis_completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "app/live/stop_signal.h"
#include "app/stage/config_edit.h"
#include "app/stage/dynamics_text.h"
#include "app/stage/first_stage.h"
#include "app/stage/identification_report.h"
#include "app/stage/identification_result.h"
#include "app/stage/tuning.h"
#include "base/error.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "base/terminal.h"
#include "config/document/toml_edit.h"
#include "config/files/model_file.h"
#include "config/schema/settings.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {
namespace {

using identification::Identified;

Identified identified_loops(const AxisRecords& records) {
  Progress progress("identifying", 0, "trials");
  identification::IdentifyOptions identify_options = records.model;
  // The thresholds of the model become the ends of the recorded drives. The start-up moves the drive to the
  // thresholds, and it can reach these ends, but perhaps no drive beyond them.
  identify_options.observed_thresholds = true;
  identify_options.go_on = counted_trials(progress);
  return at_place(fmt::format("{}", fmt::join(records.names(), ", ")),
                  [&] { return identification::identify(records.loops, identify_options); });
}

std::string validation_line(const model::HysteresisParameters& parameters, double delay_s,
                            const AxisRecords& records) {
  const Validation seen =
      validate(model::Hysteresis(parameters), *records.unseen,
               {.lag = {.delay_s = delay_s, .dynamics = {}}, .estimate_s = {}, .memory = {}});
  return fmt::format(
      "unseen: {} is predicted with an error of {:.3g} % RMS, {:.3g} % at most, relative to the output span; "
      "the model was identified without this record",
      records.unseen_file->filename().string(), 100.0 * seen.all.rms / seen.output_span,
      100.0 * seen.all.max / seen.output_span);
}

/// Returns the uncertainty of a mode that the user stated: the frequency may differ by 10 %, and the damping
/// ratio may be smaller by a factor of 1.5. If the frequency may be above half the rate, its interval has no
/// upper end, so that the loop must be stable with every higher frequency.
controller::PlantUncertainty stated_uncertainty(const controller::Delays& stated, double rate_Hz) {
  constexpr double percent = 10.0;
  controller::PlantUncertainty uncertainty = controller::around(stated, percent);
  uncertainty.damping_ratio.lo /= stated_damping_factor;
  if (uncertainty.resonance_Hz.hi > 0.5 * rate_Hz)
    uncertainty.resonance_Hz.hi = std::numeric_limits<double>::infinity();
  return uncertainty;
}

void set_loop_of(Stage& stage, std::size_t i, controller::LoopConfig loop) {
  loop.delays = in_whole_microseconds(loop.delays);
  set_loop(stage.config.axes[i].control, loop);
  derive(stage.config, i);
}

/// Writes the identified dynamics into [axis.control] and [axis.twin] of axis i, with comments that state
/// their source, and sets the cautious loop for them.
void set_dynamics(Stage& stage, std::size_t i, const IdentifiedPlant& plant) {
  const controller::Delays delays = in_whole_microseconds(plant.delays);
  set_loop_of(stage, i,
              cautious_loop(plant, stage.config.controller.rate_Hz,
                            controller::SensitivityRule{}.resonance_percent, controller::CautiousRule{}));
  config::AxisConfig& axis = stage.config.axes[i];
  twin::AxisConfig& twin = axis.twin;
  twin.plant.mode.natural_frequency_Hz = delays.resonance_Hz;
  twin.plant.mode.damping_ratio = delays.damping_ratio;
  twin.plant.amplifier.bandwidth_Hz = delays.amplifier_bandwidth_Hz;
  if (delays.sensor_delay.count() > 0) twin.sensor.delay = delays.sensor_delay;
  const auto path = [&](const config::Member& member) { return path_of(stage.config, member); };
  stage.comments[path(axis.control.delays.amplifier_bandwidth_Hz)] =
      "from the step record; includes the sensor's lag";
  stage.comments[path(twin.plant.amplifier.bandwidth_Hz)] = "from the step record";
  if (!plant.mode) return;
  stage.comments[path(axis.control.delays.resonance_Hz)] = "from the step record";
  stage.comments[path(axis.control.delays.damping_ratio)] = "from the step record";
}

std::string dynamics_line(const controller::Delays& delays) {
  return fmt::format(
      "dynamics: resonance {:.5g} Hz, damping ratio {:.3g}, "
      "amplifier bandwidth {:.4g} Hz, sensor delay {:.3g} ms",
      delays.resonance_Hz, delays.damping_ratio, delays.amplifier_bandwidth_Hz, 1e3 * delays.sensor_s());
}

/// Returns a line for the user: the identified dynamics, and the record from which they were identified.
std::string dynamics_line(const std::string& record, const IdentifiedPlant& plant, double stated_Hz) {
  std::string text = fmt::format("{}; from {}", dynamics_line(plant.delays), record);
  if (!plant.mode)
    text += fmt::format(
        ", which shows delay and lag but no mode ({}): "
        "the loop uses the stated resonance of {:g} Hz and keeps its margins with every higher resonance",
        plant.not_shown, stated_Hz);
  else if (!is_as_stated(*plant.mode, stated_Hz))
    text += fmt::format(", instead of the stated {:g} Hz", stated_Hz);
  if (plant.pure_s > 0.0)
    text += fmt::format("; {:.3g} ms is pure delay, attributed to the sensor", 1e3 * plant.pure_s);
  return text;
}

std::string loop_text(const Candidate& best, double resonance_percent) {
  std::string text = fmt::format("kp {:.4g}, ki {:.4g} 1/s", best.loop.pi.kp, best.loop.pi.ki_per_s);
  if (best.loop.measurement_filter_Hz > 0.0)
    text += fmt::format(", low pass {:g} Hz", best.loop.measurement_filter_Hz);
  if (best.loop.notch) text += fmt::format(", notch at {:.5g} Hz", best.loop.notch->frequency_Hz);
  if (best.judged)
    text += fmt::format("; sensitivity at most {:.3g}, {:.3g} if the resonance is {:g} % off",
                        best.judged->margins.peak_sensitivity, best.judged->worst.peak_sensitivity,
                        resonance_percent);
  return text;
}

/// Returns the candidate that is written to the configuration: the cautious loop, or the proposed one if the
/// cautious loop does not track.
const Candidate& first_proposal(const TuningReport& report) {
  const Candidate& cautious = report.candidates.back();
  return cautious.has_run() ? cautious : report.proposed();
}

/// Returns true if the candidate has cautious gains. These are the last candidate, which is designed by the
/// cautious rule, and the first candidate, which is the present setting: set_dynamics() has already written
/// cautious gains into the configuration.
bool is_cautious(const TuningReport& report, const Candidate& candidate) {
  return &candidate == &report.candidates.back() || &candidate == &report.present();
}

std::string loop_line(const TuningReport& report) {
  const Candidate& first = first_proposal(report);
  return fmt::format("loop: {}, {}", loop_name(report), loop_text(first, report.rule.resonance_percent)) +
         (is_cautious(report, first)
              ? fmt::format("; margins of {:g} degrees and {:.2g} dB", report.cautious_rule.phase_margin_deg,
                            decibel(report.cautious_rule.gain_margin))
              : "; the configuration gets this loop because the cautious loop (with lower gains) does not "
                "track the reference in a rehearsal");
}

TuningReport tuned_by_step(Stage& stage, std::size_t i, const AxisRecords& records,
                           const IdentifiedPlant& plant) {
  const std::string name = stage.config.axes[i].wire.name;
  const controller::Delays stated = stage.config.axes[i].control.delays;
  set_dynamics(stage, i, plant);
  print_lines(name, {dynamics_line(records.step_file->filename().string(), plant, stated.resonance_Hz)});
  const config::Config config =
      chosen_axis_of(stage.config, {.config = stage.file(), .axis = name, .interface = {}, .rehearse = true});
  TuningReport report = tuning_of(config);
  evaluate(report, plant, config, twin_config(stage.config));
  throw_if_signalled();
  if (stated.sensor_s() == 0.0) report.unshared_s = plant.delays.lag_s() + plant.delays.sensor_s();
  set_loop_of(stage, i, first_proposal(report).loop);
  print_lines(name, {loop_line(report)});
  if (const Candidate* fast = faster_of(report))
    print_lines(name,
                {fmt::format("faster: {}, {}", fast->name, loop_text(*fast, report.rule.resonance_percent))});
  if (const auto undrawn =
          draw_response(report, *records.step, stage.file().parent_path() / (name + ".bode.svg")))
    print_lines(name, {"no picture of the loop: " + *undrawn});
  return report;
}

void set_as_stated(Stage& stage, std::size_t i) {
  const controller::Delays stated = stage.config.axes[i].control.delays;
  const double rate_Hz = stage.config.controller.rate_Hz;
  controller::LoopConfig loop{.delays = stated, .cycle_s = 1.0 / rate_Hz};
  loop.pi = controller::unmeasured_gains(loop, stated_uncertainty(stated, rate_Hz));
  set_loop_of(stage, i, loop);
}

void print_as_stated(const config::AxisConfig& axis) {
  print_lines(axis.wire.name, {dynamics_line(axis.control.delays) + ": stated or assumed, not measured",
                               fmt::format("loop: integral alone, ki {:.4g} 1/s, "
                                           "an eighth of the stability limit for these dynamics; "
                                           "a record of small steps (--step) allows a faster loop",
                                           axis.control.law.pi.ki_per_s)});
}

/// Returns how much the twin's actuator should deviate from the model, as a share of half the output range.
/// The twin then deviates from the model by as much as the model deviates from held-out data. The result is
/// from 1 % to 10 %; it is not 0, because the true model changes from day to day.
double measured_share(const Identified& found, const AxisRecords& records) {
  constexpr double tried = 0.01, least = 0.01, most = 0.1;
  Identified other = found;
  other.parameters = not_quite(found.parameters, tried);
  double square = 0.0, samples = 0.0;
  for (std::size_t i = 0; i < records.loops.size(); ++i) {
    const std::vector<double> model = predict(found, records.loops, i),
                              off = predict(other, records.loops, i);
    for (std::size_t j = 0; j < model.size(); ++j) square += (off[j] - model[j]) * (off[j] - model[j]);
    samples += static_cast<double>(model.size());
  }
  if (!(square > 0.0)) return least;
  return std::clamp(tried * found.held_out_rms.value_or(found.overall.rms) / std::sqrt(square / samples),
                    least, most);
}

std::string plant_text(const Identified& found, const AxisRecords& records) {
  const double share = measured_share(found, records);
  return fmt::format(
             "# The twin's actuator: "
             "the identified model with deliberate errors of up to {:.2g} % of half the output range.\n",
             100.0 * share) +
         config::model_text(not_quite(found.parameters, share), {}, {}, not_quite(found.creep, share));
}

}  // namespace

Stage::Stage(std::filesystem::path file, std::string text)
    : config(config::load_text(file, text)),
      file_(std::move(file)),
      read_text_(std::move(text)),
      read_(config) {}

std::string Stage::text() const {
  config::TomlEdit text(read_text_, file_.string());
  edit(text, read_, config);
  for (const auto& [path, comment] : comments) text.set_comment(path, comment);
  return text.text();
}

std::string model_name(const std::string& axis) { return axis + ".model.toml"; }
std::string plant_name(const std::string& axis) { return axis + ".plant.toml"; }

void print_lines(const std::string& of, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) print(fmt::format("{}{}\n", of.empty() ? "" : of + ": ", line));
  flush_output();  // shows the lines now, because the next step may take seconds
}

Identified identify_axis(const std::filesystem::path& folder, const std::string& axis, AxisRecords records,
                         const model::Interval& range) {
  for (identification::Dataset& loop : records.loops)
    for (double& drive : loop.input) drive = std::clamp(drive, range.lo, range.hi);
  Identified found = identified_loops(records);
  throw_if_signalled();
  const std::vector<std::string> finding_texts = findings(records.loops, found);
  write_file(folder / model_name(axis), identified_model_text(found, records.loops, finding_texts));
  write_file(folder / plant_name(axis), plant_text(found, records));
  const auto undrawn =
      write_report(folder / (axis + ".report"), {records.loops, records.names(), found, finding_texts});
  throw_if_signalled();
  const double percent = 100.0 / found.output_span;
  print_lines(
      axis,
      {fmt::format(
          "hysteresis: {}, fits {} to {:.3g} % RMS{} of {:.5g} um; {}.report/report.html{}",
          found.search.shape.text(), fmt::join(records.names(), ", "), found.overall.rms * percent,
          found.held_out_rms ? fmt::format(" ({:.3g} % cross-validated)", *found.held_out_rms * percent) : "",
          found.output_span, axis, undrawn ? ", without pictures: " + *undrawn : "")});
  if (records.unseen) print_lines(axis, {validation_line(found.parameters, found.delay_s, records)});
  return found;
}

std::optional<IdentifiedPlant> shown_plant(const AxisRecords& records, const controller::Delays& stated) {
  if (!records.step) return std::nullopt;
  return at_place(*records.step_file, [&] { return identified_plant(*records.step, stated); });
}

TuningReport tune_axis(Stage& stage, std::size_t i, const AxisRecords& records,
                       const std::optional<IdentifiedPlant>& plant) {
  if (plant) return tuned_by_step(stage, i, records, *plant);
  set_as_stated(stage, i);
  print_as_stated(stage.config.axes[i]);
  return {};
}

void set_cautious_loop(Stage& stage, std::size_t i, const std::optional<IdentifiedPlant>& plant) {
  if (plant)
    set_dynamics(stage, i, *plant);
  else
    set_as_stated(stage, i);
}

std::string loop_name(const TuningReport& report) {
  if (report.candidates.empty()) return "integral alone";
  const Candidate& first = first_proposal(report);
  return is_cautious(report, first) ? "cautious" : first.name;
}

const Candidate* faster_of(const TuningReport& report) {
  constexpr double worth_it = 0.98;
  if (report.best == 0) return nullptr;
  const Candidate& fast = report.proposed();
  return fast.rms_percent() < worth_it * first_proposal(report).rms_percent() ? &fast : nullptr;
}

std::vector<Promise> rehearsal_of(const config::Config& config, const std::vector<TuningReport>& tuned,
                                  const std::vector<std::string>& loops) {
  std::vector<PromiseBasis> bases;
  for (std::size_t i = 0; i < config.axes.size(); ++i)
    bases.push_back(basis_of(config, i, loops[i], uncertainty_of(tuned[i])));
  return promises_of(rehearsal_setup(config), bases);
}

}  // namespace hystcan::app
