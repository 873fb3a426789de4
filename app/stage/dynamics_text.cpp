#include "app/stage/dynamics_text.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.h"

namespace hystcan::app {
namespace {

using controller::CautiousRule;
using controller::Margins;
using identification::Estimate;

std::string with_interval(const Estimate& estimate, double scale, const std::string& unit) {
  return fmt::format("{:.5g}{} (95 %: {:.5g} to {:.5g})", scale * estimate.value, unit, scale * estimate.lo,
                     scale * estimate.hi);
}

nlohmann::json to_json(const Estimate& estimate) {
  return {{"value", estimate.value},
          {"standard_error", estimate.standard_error},
          {"lo", estimate.lo},
          {"hi", estimate.hi}};
}

/// Describes which part of the total delay is a lag and which part is a pure delay.
std::string delay_shares(const IdentifiedPlant& plant) {
  if (plant.pure_s == 0.0)
    return ", as one sum: drive and position do not show the amplifier's lag and the sensor's lag separately";
  return fmt::format(
      ", including {:.3g} ms of pure delay, attributed to the sensor: "
      "if the amplifier causes this delay instead, the stage moves later than predicted, by this time",
      1e3 * plant.pure_s);
}

/// Returns a warning if identified and stated resonance differ by more than a factor of 1.5; otherwise an
/// empty text.
std::string far_from_stated(const IdentifiedPlant& plant, const controller::Delays& stated) {
  constexpr double far = 1.5;
  const double ratio = plant.delays.resonance_Hz / stated.resonance_Hz;
  if (ratio <= far && ratio >= 1.0 / far) return {};
  return line("warning", fmt::format("the stated resonance is {:g} Hz: "
                                     "above half the sampling rate, a mode appears at another frequency; "
                                     "record at a higher rate to find the right frequency",
                                     stated.resonance_Hz));
}

}  // namespace

double decibel(double gain) { return 20.0 * std::log10(gain); }

std::string line(const std::string& name, const std::string& value) {
  return fmt::format("{:<18} {}\n", name, value);
}

std::string describe(const IdentifiedPlant& plant, const controller::Delays& stated,
                     const std::string& input_unit, const std::string& output_unit) {
  const std::string unit = output_unit + " per " + input_unit;
  std::string text;
  if (plant.mode)
    text = line("natural frequency", with_interval(plant.mode->natural_frequency_Hz, 1.0, " Hz")) +
           line("damping ratio", with_interval(plant.mode->damping_ratio, 1.0, "")) +
           line("delay", with_interval(plant.mode->delay_s, 1e3, " ms") + delay_shares(plant)) +
           line("gain", with_interval(plant.mode->gain, 1.0, " " + unit));
  else
    text =
        line("mode", "not shown: " + plant.not_shown) +
        line("", fmt::format("the loop uses the stated resonance of {:g} Hz "
                             "and keeps its margins with every higher resonance",
                             stated.resonance_Hz)) +
        line("delay", with_interval(plant.late_s, 1e3, " ms in addition to the stated delay of the sensor") +
                          delay_shares(plant)) +
        line("gain", fmt::format("{:.5g} {}", plant.gain, unit));
  return text +
         line("residual", fmt::format("{:.3g} {} rms; the model explains {:.4f} % of the output's variance",
                                      plant.residual_rms, output_unit, 100.0 * plant.explained)) +
         line("chain", fmt::format("resonance {:.5g} Hz, damping ratio {:.4g}, "
                                   "amplifier bandwidth {:.5g} Hz, sensor delay {:.4g} ms: {}",
                                   plant.delays.resonance_Hz, plant.delays.damping_ratio,
                                   plant.delays.amplifier_bandwidth_Hz, 1e3 * plant.delays.sensor_s(),
                                   "with these values, the chain reproduces the samples of the record")) +
         far_from_stated(plant, stated);
}

std::string left_out_text(const IdentifiedPlant& plant) {
  return plant.left_out == 0 ? std::string() : fmt::format(", {} left out", counted(plant.left_out, "cycle"));
}

std::string describe(const Margins& margins) {
  return fmt::format(
      "{}phase margin {:.1f} deg, gain margin {:.1f} dB, "
      "open loop |L| at most {:.2f} at and beyond -180 deg, "
      "sensitivity at most {:.2f}",
      margins.stable ? "" : "NOT STABLE: ", margins.phase_margin_deg, decibel(margins.gain_margin),
      margins.peak_beyond_180, margins.peak_sensitivity);
}

std::string describe(const controller::Notch::Config& notch) {
  return fmt::format("{:.4g}, {:g}, {:g}", notch.frequency_Hz, notch.depth, notch.width);
}

std::string describe(const controller::SensitivityRule& rule) {
  return line("rule",
              fmt::format(
                  "the largest ki with any kp >= 0 for which the open loop L has |1 / (1 + L)| <= {:g} "
                  "at every frequency, for all combinations of the interval ends of resonance, "
                  "damping and delay,",
                  rule.peak_sensitivity)) +
         line("",
              fmt::format("with the resonance interval widened by {:g} % on both sides; several loops are "
                          "designed: without a filter, with a low pass, and with a notch",
                          rule.resonance_percent));
}

std::string describe(const CautiousRule& rule) {
  return line("cautious rule",
              fmt::format("the largest ki with any kp >= 0 for which the open loop L has |L| <= 1 "
                          "where the phase of L is at {:g} deg or beyond",
                          rule.phase_margin_deg - 180.0)) +
         line("", fmt::format(
                      "(phase margin {:g} deg), and |L| <= {:.3g} where the phase is at -180 deg or beyond "
                      "(gain margin {:.3g} dB, also at the resonance)",
                      rule.phase_margin_deg, 1.0 / rule.gain_margin, decibel(rule.gain_margin)));
}

Estimate later(Estimate delay_s, double s) {
  for (double* of : {&delay_s.value, &delay_s.lo, &delay_s.hi}) *of += s;
  return delay_s;
}

double microseconds(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double, std::micro>(duration).count();
}

double rounded(double value, int digits) {
  return parsed_number<double>(fmt::format("{:.{}g}", value, digits)).value_or(value);
}

nlohmann::json to_json(const Margins& margins) {
  return {{"stable", margins.stable},
          {"phase_margin_deg", margins.phase_margin_deg},
          {"gain_margin_dB", decibel(margins.gain_margin)},
          {"peak_beyond_180", margins.peak_beyond_180},
          {"peak_sensitivity", margins.peak_sensitivity},
          {"crossover_Hz", margins.crossover_Hz},
          {"bandwidth_Hz", margins.bandwidth_Hz}};
}

nlohmann::json to_json(const std::optional<controller::Notch::Config>& notch) {
  if (!notch) return nullptr;
  return {{"frequency_Hz", notch->frequency_Hz}, {"depth", notch->depth}, {"width", notch->width}};
}

nlohmann::json to_json(const IdentifiedPlant& plant) {
  nlohmann::json json{{"rows", plant.rows},
                      {"left_out", plant.left_out},
                      {"record_rate_Hz", 1.0 / plant.cycle_s},
                      {"natural_frequency_Hz", nullptr},
                      {"damping_ratio", nullptr},
                      {"delay_s", to_json(plant.mode ? plant.mode->delay_s : plant.late_s)},
                      {"pure_delay_s", plant.pure_s},
                      {"gain", {{"value", plant.gain}}},
                      {"residual_rms", plant.residual_rms},
                      {"explained", plant.explained}};
  if (plant.mode) {
    json["natural_frequency_Hz"] = to_json(plant.mode->natural_frequency_Hz);
    json["damping_ratio"] = to_json(plant.mode->damping_ratio);
    json["gain"] = to_json(plant.mode->gain);
    json["drift_per_s"] = plant.mode->drift_per_s;
  } else {
    json["mode_not_shown"] = plant.not_shown;
  }
  return json;
}

}  // namespace hystcan::app
