#include "app/report/dynamics_text.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "can/counted.h"

namespace hystcan::app {
namespace {

using controller::CautiousRule;
using controller::Margins;
using identification::Estimate;
using identification::SecondOrderFit;

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

}  // namespace

double decibel(double gain) { return 20.0 * std::log10(gain); }

std::string line(const std::string& name, const std::string& value) {
  return fmt::format("{:<18} {}\n", name, value);
}

std::string describe(const SecondOrderFit& fit, const std::string& input_unit,
                     const std::string& output_unit) {
  return line("natural frequency", with_interval(fit.natural_frequency_Hz, 1.0, " Hz")) +
         line("damping ratio", with_interval(fit.damping_ratio, 1.0, "")) +
         line("delay", with_interval(fit.delay_s, 1e3, " ms") +
                           ", one sum: drive and position cannot tell the amplifier's lag from the "
                           "sensor's delay") +
         line("gain", with_interval(fit.gain, 1.0, " " + output_unit + " per " + input_unit)) +
         line("residual", fmt::format("{:.3g} {} rms; the mode explains {:.4f} % of the output's variance",
                                      fit.residual_rms, output_unit, 100.0 * fit.explained));
}

std::string left_out_text(const SecondOrderFit& fit) {
  return fit.left_out == 0 ? std::string()
                           : fmt::format(", {} left out", can::counted(fit.left_out, "cycle"));
}

std::string describe(const Margins& margins) {
  return fmt::format(
      "{}phase margin {:.1f} deg, gain margin {:.1f} dB, |L| at most {:.2f} at and beyond -180 deg, "
      "sensitivity at most {:.2f}",
      margins.stable ? "" : "NOT STABLE: ", margins.phase_margin_deg, decibel(margins.gain_margin),
      margins.peak_beyond_180, margins.peak_sensitivity);
}

std::string describe(const controller::Delays& found, const controller::Delays& stated) {
  constexpr double far = 1.5;
  std::string text =
      line("chain",
           fmt::format(
               "{:.5g} Hz, damping {:.4g}, amplifier {:.5g} Hz: what looks like this mode in these samples",
               found.resonance_Hz, found.damping_ratio, found.amplifier_bandwidth_Hz));
  const double ratio = found.resonance_Hz / stated.resonance_Hz;
  if (ratio > far || ratio < 1.0 / far)
    text += line("warning",
                 fmt::format("the stated resonance is {:g} Hz: above half the rate a mode shows as another "
                             "one; trust neither before a record at a higher rate",
                             stated.resonance_Hz));
  return text;
}

std::string describe(const controller::Notch::Config& notch) {
  return fmt::format("{:.4g}, {:g}, {:g}", notch.frequency_Hz, notch.depth, notch.width);
}

std::string describe(const controller::SensitivityRule& rule) {
  return line("rule",
              fmt::format("the largest ki of all pairs of ki and kp >= 0 with |1 / (1 + L)| <= {:g} at every "
                          "frequency, at all corners of the intervals",
                          rule.peak_sensitivity)) +
         line("",
              fmt::format(
                  "with {:g} % more of resonance on both sides; without a filter, with a low pass, with a "
                  "notch",
                  rule.resonance_percent));
}

std::string describe(const CautiousRule& rule) {
  return line("cautious rule",
              fmt::format("the largest ki of all pairs of ki and kp >= 0 with |L| <= 1 where the phase of L "
                          "is at {:g} deg or beyond",
                          rule.phase_margin_deg - 180.0)) +
         line("", fmt::format("(phase margin {:g} deg) and |L| <= {:.3g} where it is at -180 deg or beyond "
                              "({:.3g} dB, the resonance too)",
                              rule.phase_margin_deg, 1.0 / rule.gain_margin, decibel(rule.gain_margin)));
}

std::optional<double> bandwidth_Hz_for(const Estimate& delay_s) {
  if (delay_s.lo <= 0.0) return std::nullopt;
  return rounded(1.0 / (2.0 * std::numbers::pi * delay_s.value));
}

Estimate later(Estimate delay_s, double s) {
  for (double* of : {&delay_s.value, &delay_s.lo, &delay_s.hi}) *of += s;
  return delay_s;
}

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

double rounded(double value) { return std::stod(fmt::format("{:.5g}", value)); }

std::string as_comment(const std::string& text) {
  std::string commented = "# ";
  for (const char c : text) {
    commented += c;
    if (c == '\n') commented += "# ";
  }
  commented.resize(commented.size() - 2);
  return commented;
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

nlohmann::json to_json(const SecondOrderFit& fit) {
  return {{"rows", fit.rows},
          {"left_out", fit.left_out},
          {"record_rate_Hz", 1.0 / fit.cycle_s},
          {"natural_frequency_Hz", to_json(fit.natural_frequency_Hz)},
          {"damping_ratio", to_json(fit.damping_ratio)},
          {"delay_s", to_json(fit.delay_s)},
          {"gain", to_json(fit.gain)},
          {"drift_per_s", fit.drift_per_s},
          {"residual_rms", fit.residual_rms},
          {"explained", fit.explained}};
}

}  // namespace hystcan::app
