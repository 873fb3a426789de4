#include "app/report/tuning_report.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "app/report/dynamics_text.h"
#include "app/report/report.h"
#include "can/counted.h"

namespace hystcan::app {
namespace {

using app::to_json;
using controller::AxisOutcome;
using controller::Margins;

double command_delay_us(const controller::Delays& delays) {
  return std::chrono::duration<double, std::micro>(delays.command_delay).count();
}

std::string margin_cells(const Margins& m) {
  return fmt::format("{:>11.1f} {:>10.1f} {:>9.2f} {:>12.2f} {:>14.4g}{}", m.phase_margin_deg,
                     decibel(m.gain_margin), m.peak_beyond_180, m.peak_sensitivity, m.bandwidth_Hz,
                     m.stable ? "" : "  NOT STABLE");
}

std::string margin_rows(const char* name, const Setting& setting) {
  std::string text = fmt::format("{:<14} {:>8.4g} {:>9.4g} ", name, setting.pi.kp, setting.pi.ki_per_s);
  if (!setting.loop) return text + "  ki is zero: there is no loop to judge\n";
  text += margin_cells(setting.loop->margins) + '\n';
  return text + fmt::format("{:<14} {:>8} {:>9} ", "  at the worst", "", "") +
         margin_cells(setting.loop->worst) + '\n';
}

std::string margin_table(const TuningReport& report) {
  return fmt::format("{:<14} {:>8} {:>9} {:>11} {:>10} {:>9} {:>12} {:>14}\n", "gains", "kp", "ki [1/s]",
                     "phase [deg]", "gain [dB]", "|L| 180", "sensitivity", "bandwidth [Hz]") +
         margin_rows("present", report.present) + margin_rows("proposed", report.proposed) +
         "phase, gain: margins; |L| 180: largest |L| at a phase of -180 deg or beyond; at the worst: of the "
         "corners of the intervals;\nbandwidth: of the feedback alone\n";
}

double rms_percent(const AxisOutcome& outcome) {
  return 100.0 * outcome.statistics.total().rms_um() / outcome.stroke_um;
}

bool has_run(const AxisOutcome& outcome) {
  return outcome.fault.cause == controller::Cause::none && outcome.statistics.total().samples > 0;
}

std::string prediction_row(const char* name, const Setting& setting) {
  std::string text = fmt::format("{:<14}", name);
  for (const AxisOutcome& outcome : setting.predicted)
    text += has_run(outcome) ? fmt::format(" {:>11.3f}", rms_percent(outcome))
                             : fmt::format(" {:>11}", "faulted");
  return text + '\n';
}

std::string assumptions(const TuningReport& report) {
  return fmt::format(
      "the hysteresis, the noise and the ranges of {} ([axis.twin]), not measured here; resonance, damping "
      "and delay as found here; and the configured reference of axis {} alone",
      report.actuator, report.axis);
}

std::string prediction_table(const TuningReport& report) {
  std::string text = fmt::format("predicted RMS error, % of {:g} um\n{:<14}",
                                 report.proposed.predicted.front().stroke_um, "");
  for (const controller::Structure structure : controller::all_structures)
    text += fmt::format(" {:>11}", to_string(structure));
  return text + '\n' + prediction_row("present", report.present) +
         prediction_row("proposed", report.proposed) + "it rests on " + assumptions(report) + '\n';
}

std::string was(double value) { return fmt::format("# was {}", toml_number(value)); }

std::string key(const char* name, double value, const std::string& comment) {
  return fmt::format("{:<22} = {:<10} {}\n", name, toml_number(value), comment);
}

nlohmann::json to_json(const Setting& setting) {
  nlohmann::json json{{"kp", setting.pi.kp},
                      {"ki_per_s", setting.pi.ki_per_s},
                      {"margins", nullptr},
                      {"worst_margins", nullptr},
                      {"delays",
                       {{"command_delay_us", command_delay_us(setting.delays)},
                        {"amplifier_bandwidth_Hz", setting.delays.amplifier_bandwidth_Hz},
                        {"resonance_Hz", setting.delays.resonance_Hz},
                        {"damping_ratio", setting.delays.damping_ratio}}},
                      {"predicted", nlohmann::json::object()}};
  if (setting.loop) {
    json["margins"] = to_json(setting.loop->margins);
    json["worst_margins"] = to_json(setting.loop->worst);
  }
  for (std::size_t i = 0; i < setting.predicted.size(); ++i)
    json["predicted"][std::string(to_string(controller::all_structures[i]))] = to_json(setting.predicted[i]);
  return json;
}

}  // namespace

std::string describe(const TuningReport& report) {
  const controller::Excitation::Steps& s = report.steps;
  const controller::Delays& now = report.present.delays;
  return line("experiment", fmt::format("axis {} of {}, {}: {} of {:g} {} about {:g} {}, {:g} s each, "
                                        "{} at {:g} Hz",
                                        report.axis, report.config,
                                        report.rehearsed ? "rehearsed with its twin" : "on the bus",
                                        can::counted(s.cycles, "step"), 2.0 * s.amplitude, report.drive_unit,
                                        s.centre, report.drive_unit, s.period_s,
                                        can::counted(report.fit.rows, "row"), report.rate_Hz)) +
         describe(report.fit, report.drive_unit, "um") +
         line("configured",
              fmt::format("{:g} Hz, damping {:g}, amplifier {:g} Hz, command delay {:g} ms", now.resonance_Hz,
                          now.damping_ratio, now.amplifier_bandwidth_Hz, 1e-3 * command_delay_us(now))) +
         describe(report.rule) + '\n' + margin_table(report) + '\n' + prediction_table(report);
}

std::string fragment(const TuningReport& report) {
  const Setting& before = report.present;
  const Setting& after = report.proposed;
  std::string text =
      fmt::format(
          "# Proposed for axis {} of {}; nothing has been applied. These keys replace those of its "
          "[axis.control].\n#\n",
          report.axis, report.config) +
      as_comment(describe(report)) + "\n[axis.control]\n" +
      key("kp", after.pi.kp, was(before.pi.kp) + " um per um") +
      key("ki_per_s", after.pi.ki_per_s, was(before.pi.ki_per_s)) + "\n[axis.control.delays]\n" +
      key("command_delay_us", command_delay_us(after.delays),
          was(command_delay_us(before.delays)) + "; one cycle; the measured delay counts from its end");
  if (bandwidth_Hz_for(report.fit.delay_s))
    text += key("amplifier_bandwidth_Hz", after.delays.amplifier_bandwidth_Hz,
                was(before.delays.amplifier_bandwidth_Hz) +
                    fmt::format("; represents the identified delay: {:.4g} ms = 1 / (2 pi bandwidth)",
                                1e3 * report.fit.delay_s.value));
  else
    text += "# amplifier_bandwidth_Hz: unchanged, the delay cannot be distinguished from zero\n";
  return text + key("resonance_Hz", after.delays.resonance_Hz, was(before.delays.resonance_Hz)) +
         key("damping_ratio", after.delays.damping_ratio, was(before.delays.damping_ratio));
}

nlohmann::json to_json(const TuningReport& report) {
  nlohmann::json json = to_json(report.fit);
  json["config"] = report.config;
  json["axis"] = report.axis;
  json["rehearsed"] = report.rehearsed;
  json["rate_Hz"] = report.rate_Hz;
  json["drive_unit"] = report.drive_unit;
  json["steps"] = {{"centre", report.steps.centre},
                   {"amplitude", report.steps.amplitude},
                   {"period_s", report.steps.period_s},
                   {"cycles", report.steps.cycles}};
  json["rule"] = {{"phase_margin_deg", report.rule.phase_margin_deg},
                  {"gain_margin_dB", decibel(report.rule.gain_margin)}};
  json["present"] = to_json(report.present);
  json["proposed"] = to_json(report.proposed);
  json["prediction_rests_on"] = assumptions(report);
  return json;
}

}  // namespace hystcan::app
