#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include "app/commands.h"
#include "app/output_file.h"
#include "config/config.h"
#include "config/record_file.h"
#include "identification/tuning.h"

namespace hystcan::app {
namespace {

using identification::Estimate;
using identification::Margins;
using identification::SecondOrderFit;
using identification::Tuning;

struct Options {
  std::filesystem::path data;
  std::filesystem::path output;
  std::optional<double> rate_Hz;
  bool json = false;
};

struct Found {
  std::string file;  ///< the record's name, without its folder
  std::string input_unit;
  std::string output_unit;
  SecondOrderFit fit;
  double rate_Hz = 0.0;  ///< of the loop
  Tuning tuning;
};

std::string unit_or(const std::string& unit, const char* otherwise) {
  return unit.empty() ? otherwise : unit;
}

Found find(const Options& options) {
  const config::RecordFile file = config::load_record(options.data);
  try {
    Found found;
    found.file = options.data.filename().string();
    found.input_unit = unit_or(file.record.input_unit, "input unit");
    found.output_unit = unit_or(file.record.output_unit, "output unit");
    found.fit = identification::fit_second_order(file.record);
    found.rate_Hz = options.rate_Hz.value_or(1.0 / found.fit.cycle_s);
    found.tuning = identification::tune(found.fit, 1.0 / found.rate_Hz);
    return found;
  } catch (const std::invalid_argument& error) {
    throw config::Error(fmt::format("{}: {}", options.data.string(), error.what()));
  }
}

double decibel(double gain) { return 20.0 * std::log10(gain); }

std::string with_interval(const Estimate& estimate, double scale, const char* unit) {
  return fmt::format("{:.5g}{} (95 %: {:.5g} to {:.5g})", scale * estimate.value, unit, scale * estimate.lo,
                     scale * estimate.hi);
}

std::string describe(const Margins& margins) {
  return fmt::format(
      "{}phase margin {:.1f} deg, gain margin {:.1f} dB, |L| at most {:.2f} at and beyond -180 deg, "
      "sensitivity at most {:.2f}",
      margins.stable ? "" : "NOT STABLE: ", margins.phase_margin_deg, decibel(margins.gain_margin),
      margins.peak_beyond_180, margins.peak_sensitivity);
}

/// What both the reader of the terminal and the reader of the fragment are told.
std::string describe(const Found& found) {
  const SecondOrderFit& fit = found.fit;
  const Tuning& tuning = found.tuning;
  const std::string gain_unit = " " + found.output_unit + " per " + found.input_unit;
  std::string text;
  const auto line = [&](const char* name, const std::string& value) {
    text += fmt::format("{:<18} {}\n", name, value);
  };
  line("record", fmt::format("{}: {} rows at {:.6g} Hz", found.file, fit.rows, 1.0 / fit.cycle_s));
  line("natural frequency", with_interval(fit.natural_frequency_Hz, 1.0, " Hz"));
  line("damping ratio", with_interval(fit.damping_ratio, 1.0, ""));
  line("delay",
       with_interval(fit.delay_s, 1e3, " ms") + ", the amplifier's lag and the sensor's delay in it");
  line("gain", with_interval(fit.gain, 1.0, gain_unit.c_str()));
  line("residual", fmt::format("{:.3g} {} rms; the mode explains {:.4f} % of the output's variance",
                               fit.residual_rms, found.output_unit, 100.0 * fit.explained));
  line("PI gains", fmt::format("kp {} um per um, ki {} 1/s, at {:.6g} Hz", tuning.gains.kp,
                               tuning.gains.ki_per_s, found.rate_Hz));
  line("loop", describe(tuning.margins));
  line("at the worst", describe(tuning.worst) + " (corners of the intervals)");
  line("speed", fmt::format("crossover {:.4g} Hz, bandwidth of the feedback alone {:.4g} Hz",
                            tuning.margins.crossover_Hz, tuning.margins.bandwidth_Hz));
  line("rule",
       "of all kp >= 0 and ki the largest ki with |L| <= 1 where the phase of L is at -120 deg or beyond");
  line("",
       "(phase margin 60 deg) and |L| <= 1/2 where it is at -180 deg or beyond (6 dB, the resonance too)");
  return text;
}

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string toml_rounded(double value) { return toml_number(std::stod(fmt::format("{:.5g}", value))); }

std::string as_comment(const std::string& text) {
  std::string commented = "# ";
  for (const char c : text) {
    commented += c;
    if (c == '\n') commented += "# ";
  }
  commented.resize(commented.size() - 2);
  return commented;
}

/// The preview of the reference counts an amplifier's lag 1 / (2 pi bandwidth): that is where the delay goes.
std::string delay_key(const Estimate& delay_s) {
  if (delay_s.lo <= 0.0) return "# amplifier_bandwidth_Hz: as it is, no delay can be told from none\n";
  return fmt::format(
      "amplifier_bandwidth_Hz = {}   # stands for the delay found: {:.4g} ms = 1 / (2 pi bandwidth)\n",
      toml_rounded(1.0 / (2.0 * std::numbers::pi * delay_s.value)), 1e3 * delay_s.value);
}

std::string fragment(const Found& found) {
  return "# Second-order dynamics of one axis: these keys replace those of its [axis.control].\n#\n" +
         as_comment(describe(found)) +
         fmt::format("\n[axis.control]\nkp       = {}   # um per um\nki_per_s = {}\n",
                     toml_number(found.tuning.gains.kp), toml_number(found.tuning.gains.ki_per_s)) +
         "\n[axis.control.delays]\n" + delay_key(found.fit.delay_s) +
         fmt::format("resonance_Hz  = {}\ndamping_ratio = {}\n",
                     toml_rounded(found.fit.natural_frequency_Hz.value),
                     toml_rounded(found.fit.damping_ratio.value));
}

nlohmann::json to_json(const Estimate& estimate) {
  return {{"value", estimate.value},
          {"standard_error", estimate.standard_error},
          {"lo", estimate.lo},
          {"hi", estimate.hi}};
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

nlohmann::json to_json(const Found& found) {
  const SecondOrderFit& fit = found.fit;
  return {{"rows", fit.rows},
          {"record_rate_Hz", 1.0 / fit.cycle_s},
          {"natural_frequency_Hz", to_json(fit.natural_frequency_Hz)},
          {"damping_ratio", to_json(fit.damping_ratio)},
          {"delay_s", to_json(fit.delay_s)},
          {"gain", to_json(fit.gain)},
          {"drift_per_s", fit.drift_per_s},
          {"residual_rms", fit.residual_rms},
          {"explained", fit.explained},
          {"rate_Hz", found.rate_Hz},
          {"kp", found.tuning.gains.kp},
          {"ki_per_s", found.tuning.gains.ki_per_s},
          {"margins", to_json(found.tuning.margins)},
          {"worst_margins", to_json(found.tuning.worst)}};
}

int dynamics(const Options& options) {
  refuse_to_overwrite(options.output, options.data);
  if (options.rate_Hz && !(*options.rate_Hz > 0.0 && std::isfinite(*options.rate_Hz)))
    throw config::Error(fmt::format("--rate is {}, expected a positive number", *options.rate_Hz));
  const Found found = find(options);
  OutputFile out(options.output);
  out.write(fragment(found));
  out.commit();
  fmt::print("{}", options.json ? to_json(found).dump(2) + "\n" : describe(found));
  return done;
}

}  // namespace

void add_dynamics(CLI::App& cli, int& status) {
  auto options = std::make_shared<Options>();
  CLI::App* command = cli.add_subcommand(
      "dynamics", "Natural frequency, damping and delay from a small step or chirp; PI gains from these");
  command
      ->add_option("DATA", options->data,
                   "CSV: time_s,input,output, evenly sampled; the input is the drive in force from a row's "
                   "time until the next row's")
      ->required();
  command->add_option("--output", options->output, "fragment of a configuration to write (TOML)")->required();
  command->add_option("--rate", options->rate_Hz, "of the controller, Hz (default: the record's)");
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options, &status] { status = dynamics(*options); });
}

}  // namespace hystcan::app
