#include "app/stage/tuning.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include "app/live/report.h"
#include "app/live/stop_signal.h"
#include "base/error.h"
#include "base/standard_streams.h"
#include "controller/excitation_dataset.h"
#include "identification/characterisation.h"
#include "identification/dynamics/empirical_response.h"

namespace hystcan::app {
namespace {

using controller::Excitation;
using identification::Dataset;

}  // namespace

Excitation::Steps usual_steps(const controller::Gate::Config& gate) {
  const double range = gate.drive_max - gate.drive_min;
  return {.centre = gate.drive_min + range / 2.0, .amplitude = 0.01 * range, .period_s = 0.4, .cycles = 5};
}

Excitation::Steps with_safe_amplitude(const Excitation::Steps& steps, const config::Config& config,
                                      const twin::Config& twin) {
  const auto with = [&](double amplitude) {
    Excitation::Steps smaller = steps;
    smaller.amplitude = amplitude;
    return smaller;
  };
  const Excitation::Steps chosen =
      with(amplitude_with_margin(config, twin, steps.amplitude, [&](double a) { return with(a); }));
  if (chosen.amplitude < steps.amplitude)
    note("amplitude {:g} {}, not {:g}: the twin comes near a limit with more\n", chosen.amplitude,
         config.axes[0].wire.drive_unit, steps.amplitude);
  return chosen;
}

/// The rows have the times of whole cycles, those that were left out included: sample and drive both follow the SYNC, so
/// that its jitter of some microseconds does not affect the identified mode.
Dataset measured_steps(const config::Config& config, const twin::Config& twin, const OpenLoopOptions& run,
                       const Excitation::Steps& steps) {
  const config::AxisConfig& axis = config.axes[0];
  const double rate_Hz = config.controller.rate_Hz;
  Dataset record{
      .input_unit = axis.wire.drive_unit, .output_unit = "um", .time_s = {}, .input = {}, .output = {}};
  controller::ExcitationDataset rows;
  std::uint64_t first = 0;
  const OpenLoopEnd end =
      drive_in_open_loop(in_open_loop(config, steps), twin, run, [&](const controller::CycleRecord& cycle) {
        const auto row = rows.add(cycle);
        if (!row) return;
        const std::uint64_t number = cycle.cycle + cycle.counters.overruns;
        if (record.time_s.empty()) first = number;
        record.time_s.push_back(static_cast<double>(number - first) / rate_Hz);
        record.input.push_back(row->input);
        record.output.push_back(row->output);
      });
  for (const std::string& text : end.closing) note("{}\n", text);
  end.require_finished(axis.wire.name, "stopped before the end of the experiment, nothing is written");
  return record;
}

TuningReport tuning_of(const config::Config& config, const Excitation::Steps& steps,
                       const CandidateRules& rules, bool rehearsed) {
  const config::AxisConfig& axis = config.axes[0];
  return {.config = config.file.filename().string(),
          .axis = axis.wire.name,
          .drive_unit = axis.wire.drive_unit,
          .actuator = axis.twin_model.string(),
          .rehearsed = rehearsed,
          .steps = steps,
          .rate_Hz = config.controller.rate_Hz,
          .plant = {},
          .rule = rules.sensitivity,
          .cautious_rule = rules.cautious,
          .only_cautious = rules.only_cautious,
          .candidates = {},
          .best = 0,
          .shares = {}};
}

IdentifiedPlant plant_of_steps(const Dataset& record, const config::Config& config) {
  try {
    return identified_plant(record, config.axes[0].control.delays);
  } catch (const identification::OutputFalls& error) {
    throw RunError(fmt::format("{}: {}; nothing is written", config.axes[0].wire.name, error.what()));
  } catch (const std::invalid_argument& error) {
    throw RunError(fmt::format(
        "the experiment is not conclusive: {}; nothing is written. Try another --amplitude: a large step "
        "shows the curvature of the loop, a small one is hidden by noise",
        error.what()));
  }
}

void evaluate(TuningReport& report, const IdentifiedPlant& plant, const config::Config& config,
              const twin::Config& twin, const CandidateRules& rules) {
  report.plant = plant;
  report.plant.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 / report.rate_Hz));
  stop_at_a_signal();
  report.candidates = rehearsed_candidates(config, twin, report.plant, rules);
  report.best = best_of(report.candidates, rules.only_cautious ? std::numeric_limits<double>::infinity()
                                                               : rules.sensitivity.peak_sensitivity);
  if (report.proposed().has_run()) return;
  const Candidate& last = report.candidates.back();
  const std::string ended =
      last.predicted ? describe(report.axis, last.predicted->fault) : "it is not stable";
  throw RunError(fmt::format(
      "no candidate tracks the configured reference in the rehearsal, {}: {}. Look at this limit and at "
      "[axis.twin]; `hystcan demo` shows the run, without the limit of the following error",
      last.name, ended));
}

FrequencyResponse response_of(const TuningReport& report, const Dataset& record) {
  const auto loop = [&](const Candidate& of) -> FrequencyResponse::Loop {
    return {{.delays = report.plant.delays,
             .cycle_s = 1.0 / report.rate_Hz,
             .measurement_filter_Hz = of.setting.measurement_filter_Hz,
             .notch = of.setting.notch},
            of.setting.pi};
  };
  return {.title = fmt::format("axis {} of {}: {}", report.axis, report.config, report.proposed().name),
          .measured = identification::empirical_response(record),
          .plant = report.plant.delays,
          .gain = report.plant.gain,
          .cycle_s = report.plant.cycle_s,
          .before = loop(report.present()),
          .after = loop(report.proposed())};
}

}  // namespace hystcan::app
