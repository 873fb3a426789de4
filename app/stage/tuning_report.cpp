#include "app/stage/tuning_report.h"

#include <fmt/format.h>

#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/live/report.h"
#include "app/stage/config_edit.h"
#include "app/stage/dynamics_text.h"
#include "base/text.h"
#include "can/dbc/text.h"
#include "config/document/toml_text.h"
#include "config/schema/settings.h"

namespace hystcan::app {
namespace {

using app::to_json;
using controller::AxisOutcome;
using controller::Margins;

bool outcome_has_run(const AxisOutcome& outcome) {
  return outcome.fault.cause == controller::Cause::none && outcome.statistics.total().samples > 0;
}

double rms_percent_of(const AxisOutcome& outcome) {
  return 100.0 * outcome.statistics.total().rms_um() / outcome.stroke_um;
}

/// Returns the stroke in um from the first candidate that was rehearsed; 0 if none was.
double stroke_um(const TuningReport& report) {
  for (const Candidate& of : report.candidates)
    if (of.predicted) return of.predicted->stroke_um;
  return 0.0;
}

std::string margin_cells(const Margins& m) {
  return fmt::format(" {:>11.1f} {:>9.1f} {:>7.2f} {:>11.2f} {:>14.4g}", m.phase_margin_deg,
                     decibel(m.gain_margin), m.peak_beyond_180, m.peak_sensitivity, m.bandwidth_Hz);
}

const char* preview_of(const controller::Delays& delays) {
  if (delays.plant_inverse) return "inverse";
  return delays.second_order ? "2nd" : "mean";
}

std::string filter_cells(const Candidate& of) {
  const std::string low_pass = of.loop.measurement_filter_Hz > 0.0
                                   ? fmt::format("{:.4g}", of.loop.measurement_filter_Hz)
                                   : std::string("-");
  const std::string notch = of.loop.notch ? describe(*of.loop.notch) : std::string("-");
  return fmt::format(" {:>13} {:>21} {:>7}", low_pass, notch, preview_of(of.loop.delays));
}

std::optional<double> true_rms_percent(const Candidate& of) {
  if (!of.predicted || !of.true_rms_um) return std::nullopt;
  return 100.0 * *of.true_rms_um / of.predicted->stroke_um;
}

std::string error_cell(const Candidate& of) {
  const auto percent = true_rms_percent(of);
  if (of.has_run())
    return fmt::format(" {:>11.3f} {:>8}\n", of.rms_percent(),
                       percent ? fmt::format("{:.3f}", *percent) : std::string("-"));
  return of.predicted ? "              faulted\n" : "           NOT STABLE\n";
}

std::string candidate_rows(const Candidate& of, bool is_proposed) {
  const std::string first = fmt::format("{:<2}{:<12} {:>7.4g} {:>9.4g}", is_proposed ? ">" : "", of.name,
                                        of.loop.pi.kp, of.loop.pi.ki_per_s) +
                            filter_cells(of);
  if (!of.judged) return first + fmt::format(" {:>56}", "ki is zero: no margins") + error_cell(of);
  return first + margin_cells(of.judged->margins) + error_cell(of) +
         fmt::format("{:<2}{:<73}", "", "  worst case") + margin_cells(of.judged->worst) +
         (of.judged->worst.stable ? "\n" : "  NOT STABLE\n");
}

std::string candidate_table(const TuningReport& report) {
  std::string text =
      fmt::format("{:<14} {:>7} {:>9} {:>13} {:>21} {:>7} {:>11} {:>9} {:>7} {:>11} {:>14} {:>11} {:>8}\n",
                  "candidate", "kp", "ki [1/s]", "low pass [Hz]", "notch [Hz]", "preview", "phase [deg]",
                  "gain [dB]", "|L| 180", "sensitivity", "bandwidth [Hz]", "RMS [%]", "true [%]");
  for (std::size_t i = 0; i < report.candidates.size(); ++i)
    text += candidate_rows(report.candidates[i], i == report.best);
  return text +
         fmt::format(
             "phase, gain: stability margins. |L| 180: largest |L| of the open loop L at -180 deg or beyond. "
             "bandwidth: without feed-forward.\n"
             "notch: frequency, depth, width. worst case: the worst combination of the interval ends of "
             "resonance, damping and delay, with the resonance interval widened by {:g} %.\n"
             "RMS: predicted error with the configured reference, at the samples. "
             "Column true: the same error, at and between the samples. "
             "Both errors are in % of the stroke, {:g} um.\n",
             report.rule.resonance_percent, stroke_um(report));
}

/// Returns a line that recommends the cautious candidate for the first run; an empty text if the proposal is
/// the cautious candidate itself, or if the cautious candidate does not track.
std::string cautious_line(const TuningReport& report) {
  const Candidate& cautious = report.candidates.back();
  if (report.only_cautious || !cautious.has_run() || &cautious == &report.proposed()) return {};
  return line("cautious",
              fmt::format("predicted error {:.3f} %, margins of {:g} degrees and {:.2g} dB: "
                          "recommended for the first run on a bench; --cautious proposes this loop",
                          cautious.rms_percent(), report.cautious_rule.phase_margin_deg,
                          decibel(report.cautious_rule.gain_margin)));
}

std::string choice(const TuningReport& report) {
  const Candidate &present = report.present(), &best = report.proposed();
  if (report.best == 0)
    return line("proposed", "the present setting, unchanged: no candidate is predicted to track better");
  return line("proposed", fmt::format("{}: the smallest predicted error, {:.3f} %; present setting: {}",
                                      best.name, best.rms_percent(),
                                      present.has_run() ? fmt::format("{:.3f} %", present.rms_percent())
                                                        : std::string("not stable, or faulted")));
}

std::string prediction_row(const char* name, const Candidate& of) {
  std::string text = fmt::format("{:<14}", name);
  if (of.by_structure.empty()) text += "  not rehearsed";
  for (const AxisOutcome& outcome : of.by_structure)
    text += outcome_has_run(outcome) ? fmt::format(" {:>11.3f}", rms_percent_of(outcome))
                                     : fmt::format(" {:>11}", "faulted");
  return text + '\n';
}

std::string assumptions(const TuningReport& report) {
  return fmt::format(
      "hysteresis, noise and ranges of {} ([axis.twin]), which this command did not measure. "
      "The prediction uses the resonance, damping and delay that this command identified. "
      "Only axis {} moves, along its configured reference",
      report.actuator, report.axis);
}

std::string prediction_table(const TuningReport& report) {
  std::string text = fmt::format("predicted RMS error of each structure, % of the stroke of {:g} um\n{:<14}",
                                 stroke_um(report), "");
  for (const controller::Structure structure : controller::all_structures)
    text += fmt::format(" {:>11}", to_string(structure));
  return text + '\n' + prediction_row("present", report.present()) +
         prediction_row("proposed", report.proposed()) + "the prediction uses " + assumptions(report) + '\n';
}

std::string promise_lines(const TuningReport& report) {
  if (!report.promise) return {};
  std::string text = '\n' + text_of(*report.promise) + '\n';
  if (report.offer) text += texts_of(*report.offer, {*report.promise}).front() + ", with a cautious loop\n";
  return text;
}

std::string experiment_line(const TuningReport& report) {
  const controller::Excitation::Steps& s = report.steps;
  return line(
      "experiment",
      fmt::format("axis {} of {}, {}: {} of {:g} {} around {:g} {}, {:g} s each, "
                  "{} at {:g} Hz{}",
                  report.axis, report.config, report.rehearsed ? "rehearsed with its twin" : "on the bus",
                  counted(s.cycles, "step"), 2.0 * s.amplitude, report.drive_unit, s.centre,
                  report.drive_unit, s.period_s, counted(report.plant.rows, "row"), report.rate_Hz,
                  left_out_text(report.plant)));
}

std::string record_line(const TuningReport& report) {
  return line("dataset",
              fmt::format("{}: {} at {:.6g} Hz{}; for axis {} of {} at {:g} Hz", report.record,
                          counted(report.plant.rows, "row"), 1.0 / report.plant.cycle_s,
                          left_out_text(report.plant), report.axis, report.config, report.rate_Hz));
}

/// Returns a default axis configuration in which only the loop of the candidate is set.
config::AxisConfig axis_with(const Candidate& candidate) {
  config::AxisConfig axis;
  set_loop(axis.control, candidate.loop);
  return axis;
}

/// Returns the delays as JSON; the members are the keys of [axis.control.delays].
nlohmann::json to_json(const controller::Delays& delays) {
  nlohmann::json json;
  for (const config::Setting& key : config::settings(delays))
    json[key.path] = nlohmann::json::parse(key.value);
  return json;
}

nlohmann::json to_json(const Candidate& of) {
  const nlohmann::json none;
  const auto true_percent = of.has_run() ? true_rms_percent(of) : std::nullopt;
  return {{"name", of.name},
          {"kp", of.loop.pi.kp},
          {"ki_per_s", of.loop.pi.ki_per_s},
          {"measurement_filter_Hz", of.loop.measurement_filter_Hz},
          {"notch", to_json(of.loop.notch)},
          {"margins", of.judged ? to_json(of.judged->margins) : none},
          {"worst_margins", of.judged ? to_json(of.judged->worst) : none},
          {"delays", to_json(of.loop.delays)},
          {"predicted_rms_percent", of.has_run() ? nlohmann::json(of.rms_percent()) : none},
          {"predicted_true_rms_percent", true_percent ? nlohmann::json(*true_percent) : none}};
}

/// Returns to_json() of the candidate with the additional member "predicted": its predicted outcome with each
/// structure of the control law, such as "inverse+pi".
nlohmann::json to_whole_json(const Candidate& of) {
  nlohmann::json json = to_json(of);
  json["predicted"] = nlohmann::json::object();
  for (std::size_t i = 0; i < of.by_structure.size(); ++i)
    json["predicted"][std::string(to_string(controller::all_structures[i]))] = to_json(of.by_structure[i]);
  return json;
}

}  // namespace

bool Candidate::has_run() const { return predicted && outcome_has_run(*predicted); }
double Candidate::rms_percent() const { return rms_percent_of(*predicted); }

std::size_t best_of(const std::vector<Candidate>& candidates, double peak_sensitivity) {
  constexpr double rounding = 1.001;
  const Candidate& present = candidates.front();
  const auto is_worse_between_samples = [&](const Candidate& of) {
    return present.has_run() && of.true_rms_um && present.true_rms_um &&
           *of.true_rms_um > *present.true_rms_um;
  };
  std::size_t best = 0;
  // The present setting stays unless another setting has an error that is smaller by this share.
  constexpr double least_gain = 0.02;
  double least = present.has_run() ? (1.0 - least_gain) * present.rms_percent()
                                   : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].has_run() && !is_worse_between_samples(candidates[i]) &&
        (!candidates[i].judged ||
         candidates[i].judged->worst.peak_sensitivity <= rounding * peak_sensitivity) &&
        candidates[i].rms_percent() < least) {
      least = candidates[i].rms_percent();
      best = i;
    }
  return best;
}

Uncertainty uncertainty_of(const TuningReport& report) {
  Uncertainty uncertainty{.unshared_s = report.unshared_s,
                          .share_error = report.plant.share_error,
                          .mode_error = report.plant.mode_error};
  if (report.unshared_s > 0.0) uncertainty.sensor_share = report.plant.delays.sensor_s() / report.unshared_s;
  return uncertainty;
}

std::string describe(const TuningReport& report) {
  const controller::Delays& now = report.present().loop.delays;
  return (report.record.empty() ? experiment_line(report) : record_line(report)) +
         describe(report.plant, now, report.drive_unit, "um") +
         line("configured", fmt::format("resonance {:g} Hz, damping ratio {:g}, "
                                        "amplifier bandwidth {:g} Hz, command delay {:g} ms",
                                        now.resonance_Hz, now.damping_ratio, now.amplifier_bandwidth_Hz,
                                        1e-3 * microseconds(now.command_delay))) +
         (report.only_cautious ? std::string() : describe(report.rule)) + describe(report.cautious_rule) +
         '\n' + candidate_table(report) + choice(report) + cautious_line(report) + '\n' +
         prediction_table(report) + promise_lines(report);
}

std::string fragment(const TuningReport& report) {
  const config::AxisConfig before = axis_with(report.present()), after = axis_with(report.proposed());
  const controller::Delays& delays = after.control.delays;
  Notes notes{{after.control.law.pi.kp, " um per um"},
              {after.control.law.pi.ki_per_s, ""},
              {delays.command_delay, "; one cycle: the amplifier applies a setpoint at the next SYNC"},
              {delays.resonance_Hz, ""},
              {delays.damping_ratio, ""}};
  if (delays.amplifier_bandwidth_Hz != before.control.delays.amplifier_bandwidth_Hz)
    notes.emplace_back(
        delays.amplifier_bandwidth_Hz,
        fmt::format("; amplifier and sensor together: {:.4g} ms of lag", 1e3 * report.plant.delays.lag_s()));
  if (delays.sensor_delay != before.control.delays.sensor_delay)
    notes.emplace_back(delays.sensor_delay,
                       "; a pure delay, in addition to the lag of amplifier_bandwidth_Hz");
  const auto comment = [](const std::string& text) { return config::toml_comment(can::dbc::to_utf8(text)); };
  return comment(fmt::format("Proposed for axis {} of {}; nothing has been applied. "
                             "These keys replace the same keys in [axis.control] of this axis.\n",
                             report.axis, report.config)) +
         "#\n" + comment(describe(report)) + control_fragment(before, after, notes);
}

nlohmann::json to_json(const TuningReport& report) {
  nlohmann::json json = to_json(report.plant);
  json["config"] = report.config;
  json["axis"] = report.axis;
  json["rate_Hz"] = report.rate_Hz;
  json["drive_unit"] = report.drive_unit;
  if (report.record.empty()) {
    json["rehearsed"] = report.rehearsed;
    json["steps"] = {{"centre", report.steps.centre},
                     {"amplitude", report.steps.amplitude},
                     {"period_s", report.steps.period_s},
                     {"cycles", report.steps.cycles}};
  } else {
    json["record"] = report.record;
  }
  json["rule"] = {{"phase_margin_deg", report.cautious_rule.phase_margin_deg},
                  {"gain_margin_dB", decibel(report.cautious_rule.gain_margin)},
                  {"resonance_percent", report.rule.resonance_percent}};
  if (!report.only_cautious) json["rule"]["peak_sensitivity"] = report.rule.peak_sensitivity;
  json["candidates"] = nlohmann::json::array();
  for (const Candidate& candidate : report.candidates) json["candidates"].push_back(to_json(candidate));
  json["present"] = to_whole_json(report.present());
  json["proposed"] = to_whole_json(report.proposed());
  json["promise"] = report.promise ? to_json(*report.promise) : nlohmann::json();
  json["better_rate"] = report.offer ? nlohmann::json{{"rate_Hz", report.offer->rate_Hz},
                                                      {"promise", to_json(report.offer->promises.front())}}
                                     : nlohmann::json();
  json["prediction_rests_on"] = assumptions(report);
  return json;
}

}  // namespace hystcan::app
